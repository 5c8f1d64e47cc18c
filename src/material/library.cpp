#include "material/library.hpp"

#include <algorithm>

#include "base/units.hpp"

namespace calor {
namespace {

Function to_function(const LibraryValue& v, const std::string& si) {
  if (!v.unit.empty()) return Function::formula(v.value, {.value = v.unit, .si = si});
  const auto [number, unit] = split_quantity(v.value);
  return Function::constant(to_si(number, unit, si));
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
  static const std::vector<LibraryMaterial> all = {
      {"alumina",
       {"5.85 + 26524.4*exp(-0.002*T)/(242.85 + T)", "W/(m K)",
        "Munro, J. Am. Ceram. Soc. 80 (1997) 1919: 5.85 + 15360 exp(-0.002 t)/(t + 516), t in degC, to 1300 degC"},
       {"3984 kg/m^3", "", "Munro 1997 (NIST SRD 150), dense alumina, 20 degC"},
       {"1178 J/(kg K)", "", "NIST WebBook (Chase 1998): 120.135 J/(mol K) at 800 K"}},
      {"zirconia",
       {"2.8 W/(m K)", "", "Rong & Kisu, nonlinear heat transfer in graded materials by SPH (2010)"},
       {"6050 kg/m^3", "", "tetragonal zirconia polycrystal, nominal"},
       {"600 J/(kg K)", "", "NIST WebBook (Chase 1998): 73.45 J/(mol K) at 800 K = 596, rounded"}},
      {"Ti-6Al-4V",
       {"6.7 W/(m K)", "", "ASM Handbook 2 (1990), room temperature"},
       {"4430 kg/m^3", "", "ASM Handbook 2 (1990), room temperature"},
       {"526 J/(kg K)", "", "ASM Handbook 2 (1990), room temperature"}},
      {"aluminium", {"237 W/(m K)", "", a1}, {"2702 kg/m^3", "", a1}, {"903 J/(kg K)", "", a1}},
      {"copper", {"401 W/(m K)", "", a1}, {"8933 kg/m^3", "", a1}, {"385 J/(kg K)", "", a1}},
      {"iron", {"80.2 W/(m K)", "", a1}, {"7870 kg/m^3", "", a1}, {"447 J/(kg K)", "", a1}},
      {"mild steel",
       {"63.9 W/(m K)", "", a1 + " (AISI 1010)"},
       {"7832 kg/m^3", "", a1 + " (AISI 1010)"},
       {"434 J/(kg K)", "", a1 + " (AISI 1010)"}},
      {"stainless steel 304", {"14.9 W/(m K)", "", a1}, {"7900 kg/m^3", "", a1}, {"477 J/(kg K)", "", a1}},
      {"air", {"0.0263 W/(m K)", "", a4}, {"1.1614 kg/m^3", "", a4}, {"1007 J/(kg K)", "", a4}},
      {"water", {"0.613 W/(m K)", "", a6}, {"997 kg/m^3", "", a6}, {"4179 J/(kg K)", "", a6}},
  };
  return all;
}

const LibraryMaterial* find_in_library(const std::string& name) {
  const auto& all = material_library();
  const auto found = std::ranges::find(all, name, &LibraryMaterial::name);
  return found == all.end() ? nullptr : &*found;
}

}  // namespace calor
