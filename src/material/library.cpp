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

Function interpolated(const std::vector<std::pair<double, double>>& rows) {
  std::vector<double> T, value;
  for (const auto& [t, v] : rows) T.push_back(t + 273.15), value.push_back(v);
  return Function::of_temperature(Curve::through(std::move(T), std::move(value), Interpolation::linear));
}

/// Dry concrete of EN 1992-1-2, the lower limit of its conductivity, t in degC.
double concrete_conductivity(double t) { return 1.36 - 0.136 * (t / 100) + 0.0057 * (t / 100) * (t / 100); }
double concrete_specific_heat(double t) {
  if (t <= 100) return 900;
  if (t <= 200) return 900 + (t - 100);
  return t <= 400 ? 1000 + (t - 200) / 2 : 1100;
}

Function to_function(const LibraryValue& v, const std::string& si) {
  if (!v.table.empty()) return interpolated(v.table);
  if (v.law) return tabulated(v.law);
  if (!v.unit.empty()) return Function::formula(v.value, {.value = v.unit, .si = si});
  return Function::constant(read_number(Value::of_text(v.value, {}), {"value", Kind::quantity, si, required, ""}));
}

}  // namespace

SimpleProperties LibraryMaterial::properties() const {
  return {.conductivity = to_function(conductivity, "W/(m K)"),
          .density = to_function(density, "kg/m^3"),
          .specific_heat = to_function(specific_heat, "J/(kg K)"),
          .latent = melting ? std::optional(melting->latent) : std::nullopt};
}

const std::vector<LibraryMaterial>& material_library() {
  static const std::string incropera = "Incropera & DeWitt, Fundamentals of Heat and Mass Transfer, ";
  static const std::string a1 = incropera + "table A.1, 300 K", a4 = incropera + "table A.4, 300 K, 1 atm",
                           a6 = incropera + "table A.6, saturated liquid, 300 K";
  static const std::string en = "EN 1993-1-2:2005, clause ";
  static const std::string special_metals = "Special Metals, Inconel alloy 625 (SMC-063)",
                           snead = "Snead et al., J. Nucl. Mater. 371 (2007) 329, high-purity beta SiC, dense",
                           kim = "Kim, ANL-75-55 (1975), type 316", fink = "Fink, J. Nucl. Mater. 279 (2000) 1";
  static const std::string crc = "CRC Handbook of Chemistry and Physics, section 6, properties of ice",
                           crc_water = crc + " and of water from 0 to 100 degC";
  static const std::string iso = "ISO 10456:2007, gypsum plasterboard of 900 kg/m^3",
                           ideas = "IDEAS library (KU Leuven), rock wool", sae = "a179.net, SAE 1045",
                           data_book = "in the Heat and Mass Transfer Data Book of carbon steel with 0.5 % C";
  static const std::string mills =
                               "Mills, Recommended Values of Thermophysical Properties for Selected Commercial "
                               "Alloys (2002), Ti-6Al-4V",
                           agazhanov = "Agazhanov, Samoshkin & Kozlovskii, J. Phys. Conf. Ser. 1382 (2019) 012175";
  static const std::string en2 = "EN 1992-1-2:2004, clause ";
  static const std::string vdi = "VDI Heat Atlas, 2nd edition (2010), refractories, mullite brick",
                           robie = "Robie & Hemingway, USGS Bulletin 2131 (1995), Al6Si2O13";
  static const std::vector<LibraryMaterial> all = {
      {"Inconel 625",
       {"table from 21 to 982 degC: 9.8 to 25.2",
        "W/(m K)",
        special_metals,
        nullptr,
        {{21, 9.8},
         {38, 10.1},
         {93, 10.8},
         {204, 12.5},
         {316, 14.1},
         {427, 15.7},
         {538, 17.5},
         {649, 19.0},
         {760, 20.8},
         {871, 22.8},
         {982, 25.2}}},
       {"8440 kg/m^3", "", special_metals},
       {"table from 21 to 982 degC: 410 to 645",
        "J/(kg K)",
        special_metals,
        nullptr,
        {{21, 410},
         {93, 427},
         {204, 456},
         {316, 481},
         {427, 511},
         {538, 536},
         {649, 565},
         {760, 590},
         {871, 620},
         {982, 645}}},
       294,
       1255},
      {"Inconel 718",
       {"5.291 + 0.0152*T + 1.382e-6*T^2", "W/(m K)", agazhanov},
       {"8170 kg/m^3", "", agazhanov + ", room temperature"},
       {"362 + 0.2118*T", "J/(kg K)", agazhanov},
       298,
       800},
      {"stainless steel 316L",
       {"9.248 + 0.01571*T", "W/(m K)", kim},
       {"7954 kg/m^3", "", kim + ", 300 K"},
       {"459 + 0.1328*T", "J/(kg K)", kim},
       300,
       1600},
      {"aluminium 6061-T6",
       {"167 W/(m K)", "", "ASM Handbook 2 (1990), room temperature"},
       {"2700 kg/m^3", "", "ASM Handbook 2 (1990), room temperature"},
       {"896 J/(kg K)", "", "ASM Handbook 2 (1990), room temperature"},
       250,
       400},
      {"silicon carbide",
       {"1/(-0.0003 + 1.05e-5*T)", "W/(m K)", "Snead et al., J. Nucl. Mater. 371 (2007) 329, single crystal"},
       {"3210 kg/m^3", "", snead},
       {"925.65 + 0.3772*T - 7.9259e-5*T^2 - 3.1946e7/T^2", "J/(kg K)", snead},
       300,
       1800},
      {"uranium dioxide",
       {"100/(7.5408 + 17.692*(T/1000) + 3.6142*(T/1000)^2) + 6400/(T/1000)^2.5*exp(-16350/T)", "W/(m K)",
        fink + ", of 95 % of the theoretical density"},
       {"10410 kg/m^3", "", fink + ", 95 % of 10963 kg/m^3"},
       {"(52.1743 + 87.951*(T/1000) - 84.2411*(T/1000)^2 + 31.542*(T/1000)^3 - 2.6334*(T/1000)^4 - "
        "0.71391/(T/1000)^2)/0.27003",
        "J/(kg K)", fink},
       298,
       3120},
      {"concrete EN 1992-1-2",
       {"1.36 - 0.136 (t/100) + 0.0057 (t/100)^2, t in degC", "W/(m K)", en2 + "3.3.3, lower limit",
        concrete_conductivity},
       {"2300 kg/m^3", "", "EN 1994-1-2:2005, clause 3.4, normal weight"},
       {"900 to 100 degC, rising to 1000 at 200 and to 1100 at 400 degC", "J/(kg K)", en2 + "3.3.2, dry",
        concrete_specific_heat},
       293,
       1473},
      {"ice",
       {"table from -20 to 0 degC: 2.4 to 2.14", "W/(m K)", crc, nullptr, {{-20, 2.4}, {-10, 2.3}, {0, 2.14}}},
       {"917 kg/m^3", "", crc + ", 0 degC"},
       {"table from -20 to 0 degC: 1960 to 2110", "J/(kg K)", crc, nullptr, {{-20, 1960}, {-10, 2030}, {0, 2110}}},
       253,
       273},
      {"water and ice",
       {"table from -20 to 50 degC: 2.4 to 2.14 of ice, 0.561 to 0.6435 of water",
        "W/(m K)",
        crc_water,
        nullptr,
        {{-20, 2.4},
         {-10, 2.3},
         {-0.5, 2.14},
         {0.5, 0.561},
         {10, 0.58},
         {20, 0.5984},
         {30, 0.6154},
         {40, 0.6305},
         {50, 0.6435}}},
       {"917 kg/m^3", "", crc + ", ice of 0 degC: cells hold the same mass before and after"},
       {"table from -20 to 50 degC: 1960 to 2110 of ice, 4217.6 to 4180.6 of water",
        "J/(kg K)",
        crc_water,
        nullptr,
        {{-20, 1960},
         {-10, 2030},
         {-0.5, 2110},
         {0.5, 4217.6},
         {10, 4192.1},
         {20, 4181.8},
         {30, 4178.4},
         {40, 4178.5},
         {50, 4180.6}}},
       253,
       323,
       LibraryMelting{{.heat = 333.6e3, .solidus = 272.65, .liquidus = 273.65}, crc}},
      {"gypsum plasterboard",
       {"0.25 W/(m K)", "", iso},
       {"900 kg/m^3", "", iso},
       {"1000 J/(kg K)", "", iso + ", the heat that takes its water out does not count"},
       273,
       323},
      {"mineral wool",
       {"0.036 W/(m K)", "", ideas + ", EN 13162 has 0.034 to 0.045 at 10 degC, dry"},
       {"110 kg/m^3", "", ideas},
       {"840 J/(kg K)", "", ideas + ", the same for slabs of mineral wool after GOST 22950"},
       273,
       323},
      {"AISI 1045",
       {"50.9 W/(m K)", "", sae + ", 53.6 " + data_book},
       {"7872 kg/m^3", "", sae},
       {"486 J/(kg K)", "", sae + ", 465 " + data_book},
       273,
       373},
      {"alumina",
       {"5.85 + 26524.4*exp(-0.002*T)/(242.85 + T)", "W/(m K)",
        "Munro, J. Am. Ceram. Soc. 80 (1997) 1919: 5.85 + 15360 exp(-0.002 t)/(t + 516), t in degC, to 1300 degC"},
       {"3984 kg/m^3", "", "Munro 1997 (NIST SRD 150), dense alumina, 20 degC"},
       {"table from 298 to 1600 K: 775 to 1308",
        "J/(kg K)",
        "NIST-JANAF (Chase 1998), corundum: 79.015 to 133.361 J/(mol K), 101.9613 g/mol",
        nullptr,
        {{25, 775.0},
         {126.85, 942.4},
         {326.85, 1103.8},
         {526.85, 1178.2},
         {726.85, 1223.7},
         {926.85, 1257.8},
         {1126.85, 1285.6},
         {1326.85, 1308.0}}},
       298,
       1573},
      {"zirconia",
       {"2.8 W/(m K)", "", "Rong & Kisu, nonlinear heat transfer in graded materials by SPH (2010)"},
       {"6050 kg/m^3", "", "tetragonal zirconia polycrystal, nominal"},
       {"600 J/(kg K)", "", "NIST WebBook (Chase 1998): 73.45 J/(mol K) at 800 K = 596, rounded"},
       273,
       1500},
      {"mullite",
       {"table from 400 to 1200 degC: 1.45 to 1.67",
        "W/(m K)",
        vdi,
        nullptr,
        {{400, 1.45}, {600, 1.52}, {800, 1.58}, {1000, 1.63}, {1200, 1.67}}},
       {"2540 kg/m^3", "", vdi},
       {"(754.6 - 0.02943*T - 3.454e6/T^2 - 6576/sqrt(T))/0.42605", "J/(kg K)",
        robie + "; its means from 20 degC are within 2.3 % of those of the VDI Heat Atlas"},
       673,
       1473},
      {"Ti-6Al-4V",
       {"table from 25 to 600 degC: 7.0 to 14.2",
        "W/(m K)",
        mills,
        nullptr,
        {{25, 7}, {100, 7.45}, {200, 8.75}, {300, 10.15}, {400, 11.35}, {500, 12.6}, {600, 14.2}}},
       {"4420 kg/m^3", "", mills + ", 25 degC"},
       {"table from 25 to 500 degC: 546 to 651", "J/(kg K)", mills, nullptr, {{25, 546}, {400, 629}, {500, 651}}},
       298,
       773},
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
