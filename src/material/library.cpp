#include "material/library.hpp"

#include <algorithm>

#include "case/values.hpp"

namespace calor {
namespace {

/// Steel of EN 1993-1-2, t in degC; below 20 degC and above 1200 degC as there.
double steel_conductivity(double t) { return t < 800 ? 54 - 0.0333 * t : 27.3; }
double steel_specific_heat(double t) {
  if (t < 600) return 425 + t * (0.773 + t * (-1.69e-3 + t * 2.22e-6));
  if (t < 735) return 666 + 13002 / (738 - t);
  if (t < 900) return 545 + 17820 / (t - 731);
  return 650;
}

/// On every quarter of a kelvin from 20 to 1200 degC. A formula would be sampled without knowing of its kinks.
Function tabulated(double (*law)(double)) {
  std::vector<double> T, value;
  for (int n = 4 * 20; n <= 4 * 1200; ++n) T.push_back(0.25 * n + 273.15), value.push_back(law(0.25 * n));
  return Function::of_temperature(Curve::through(std::move(T), std::move(value), Interpolation::linear));
}

Function to_function(const LibraryValue& v, const std::string& si) {
  if (v.law) return tabulated(v.law);
  if (!v.unit.empty()) return Function::formula(v.value, {.value = v.unit, .si = si});
  return Function::constant(read_number(Value::of_text(v.value, {}), {"value", Kind::quantity, si, required, ""}));
}

}  // namespace

SimpleProperties LibraryMaterial::properties() const {
  return {.conductivity = to_function(conductivity, "W/(m K)"),
          .density = to_function(density, "kg/m^3"),
          .specific_heat = to_function(specific_heat, "J/(kg K)")};
}

const std::vector<LibraryMaterial>& material_library() {
  static const std::string incropera = "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, ";
  static const std::string a1 = incropera + "table A.1, 300 K", a4 = incropera + "table A.4, 300 K, 1 atm",
                           a6 = incropera + "table A.6, saturated liquid, 300 K";
  static const std::string en = "EN 1993-1-2:2005, clause ";
  static const std::vector<LibraryMaterial> all = {
      {"alumina",
       {"5.85 + 26524.4*exp(-0.002*T)/(242.85 + T)", "W/(m K)",
        "Munro, J. Am. Ceram. Soc. 80 (1997) 1919: 5.85 + 15360 exp(-0.002 t)/(t + 516), t in degC, to 1300 degC"},
       {"3984 kg/m^3", "", "Munro 1997 (NIST SRD 150), dense alumina, 20 degC"},
       {"1178 J/(kg K)", "", "NIST WebBook (Chase 1998): 120.135 J/(mol K) at 800 K"},
       273,
       1573},
      {"zirconia",
       {"2.8 W/(m K)", "", "Rong & Kisu, nonlinear heat transfer in graded materials by SPH (2010)"},
       {"6050 kg/m^3", "", "tetragonal zirconia polycrystal, nominal"},
       {"600 J/(kg K)", "", "NIST WebBook (Chase 1998): 73.45 J/(mol K) at 800 K = 596, rounded"},
       273,
       1500},
      {"Ti-6Al-4V",
       {"6.7 W/(m K)", "", "ASM Handbook 2 (1990), room temperature"},
       {"4430 kg/m^3", "", "ASM Handbook 2 (1990), room temperature"},
       {"526 J/(kg K)", "", "ASM Handbook 2 (1990), room temperature"},
       200,
       600},
      {"aluminium", {"237 W/(m K)", "", a1}, {"2702 kg/m^3", "", a1}, {"903 J/(kg K)", "", a1}, 200, 600},
      {"copper", {"401 W/(m K)", "", a1}, {"8933 kg/m^3", "", a1}, {"385 J/(kg K)", "", a1}, 200, 600},
      {"iron", {"80.2 W/(m K)", "", a1}, {"7870 kg/m^3", "", a1}, {"447 J/(kg K)", "", a1}, 200, 600},
      {"mild steel",
       {"63.9 W/(m K)", "", a1 + " (AISI 1010)"},
       {"7832 kg/m^3", "", a1 + " (AISI 1010)"},
       {"434 J/(kg K)", "", a1 + " (AISI 1010)"},
       200,
       600},
      {"carbon steel EN 1993-1-2",
       {"54 - 0.0333 t to t = 800 degC, then 27.3", "W/(m K)", en + "3.4.1.3", steel_conductivity},
       {"7850 kg/m^3", "", en + "3.2.2"},
       {"four laws to 1200 degC, with a peak of 5000 at 735 degC", "J/(kg K)", en + "3.4.1.2", steel_specific_heat},
       293,
       1473},
      {"stainless steel 304", {"14.9 W/(m K)", "", a1}, {"7900 kg/m^3", "", a1}, {"477 J/(kg K)", "", a1}, 200, 600},
      {"air", {"0.0263 W/(m K)", "", a4}, {"1.1614 kg/m^3", "", a4}, {"1007 J/(kg K)", "", a4}, 250, 400},
      {"water", {"0.613 W/(m K)", "", a6}, {"997 kg/m^3", "", a6}, {"4179 J/(kg K)", "", a6}, 273, 373},
  };
  return all;
}

const LibraryMaterial* find_in_library(const std::string& name) {
  const auto& all = material_library();
  const auto found = std::ranges::find(all, name, &LibraryMaterial::name);
  return found == all.end() ? nullptr : &*found;
}

}  // namespace calor
