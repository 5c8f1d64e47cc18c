#include "base/units.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

namespace calor {
namespace {

/// The message `work` throws.
template <class Work>
std::string refusal(const Work& work) {
  try {
    work();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "nothing was thrown";
}

TEST(Units, AreConvertedToSi) {
  EXPECT_DOUBLE_EQ(to_si(15, "mm", "m"), 0.015);
  EXPECT_DOUBLE_EQ(to_si(20, "degC", "K"), 293.15);
  EXPECT_DOUBLE_EQ(to_si(212, "degF", "K"), 373.15);  // water boils
  EXPECT_DOUBLE_EQ(to_si(2, "min", "s"), 120);
  EXPECT_DOUBLE_EQ(to_si(7.85, "g/cm^3", "kg/m^3"), 7850);
  EXPECT_DOUBLE_EQ(to_si(1, "cal", "J"), 4.1868);  // International Table calorie
  EXPECT_DOUBLE_EQ(to_si(5, "%", "1"), 0.05);
  EXPECT_DOUBLE_EQ(to_si(5, "%", ""), 0.05);
  EXPECT_DOUBLE_EQ(to_si(0.5, "", "1"), 0.5);
  EXPECT_DOUBLE_EQ(to_si(1, "degC/s", "K/s"), 1);
  for (const char* unit : {"deg", "degree", "degrees", "°"})
    EXPECT_DOUBLE_EQ(to_si(180, unit, "rad"), std::numbers::pi) << unit;
}

TEST(Units, MayBeWrittenInSeveralWays) {
  for (const char* unit : {"W/(m^2 K)", "W m-2 K-1", "W m^-2 K^-1", "W/m^2/K", "W/(m² K)", " W/(m2 K) "}) {
    EXPECT_DOUBLE_EQ(to_si(3, unit, "W/(m^2 K)"), 3) << unit;
  }
}

TEST(Units, OfDifferencesTakeNoOffset) {
  EXPECT_EQ(difference_to_si(1, "degC", "K"), 1);
  EXPECT_EQ(difference_to_si(1e-9, "degC", "K"), 1e-9);
  EXPECT_DOUBLE_EQ(difference_to_si(9, "degF", "K"), 5);
  EXPECT_DOUBLE_EQ(difference_to_si(3, "mm", "m"), 0.003);
}

TEST(Units, ThatAreUnknownOrOfAnotherDimensionAreNamed) {
  EXPECT_EQ(refusal([] { to_si(1, "Wat", "W"); }),
            "'Wat' is not a unit; units look like 'W/(m K)', 'J/(kg K)', 'mm' or 'degC'");
  EXPECT_EQ(refusal([] { to_si(1, "mm", "W/(m K)"); }), "'mm' cannot be converted to 'W/(m K)'");
  EXPECT_EQ(refusal([] { to_si(1, "", "W/(m K)"); }), "the unit is missing; one like 'W/(m K)' is needed");
  // A point is a product: these would be W/m^2 and m, times five.
  for (const char* unit : {"W/m^2.5", "m.5", "W/(m2.5 K)", "m^-1.5"})
    EXPECT_EQ(refusal([&] { to_si(1, unit, "W/m^2"); }),
              std::string("'") + unit + "' is not a unit; units look like 'W/(m K)', 'J/(kg K)', 'mm' or 'degC'");
  EXPECT_DOUBLE_EQ(to_si(1, "W/(m2.K)", "W/(m^2 K)"), 1);
  EXPECT_EQ(refusal([] { to_si(1, "mm", ""); }), "'mm' is a unit, but a number without unit is needed");
  EXPECT_EQ(refusal([] { difference_to_si(1, "mm", "K"); }), "'mm' cannot be converted to 'K'");
}

TEST(Quantities, AreANumberAndAUnit) {
  const auto expect = [](const std::string& text, double value, const std::string& unit) {
    const NumberWithUnit q = split_quantity(text);
    EXPECT_EQ(q.value, value) << text;
    EXPECT_EQ(q.unit, unit) << text;
  };
  expect("350 W/(m^2 K)", 350, "W/(m^2 K)");
  expect("  -1.5e-3 mm ", -0.0015, "mm");
  expect("20degC", 20, "degC");
  expect("+5 %", 5, "%");
  expect(".5", 0.5, "");
  expect("1.2e-5 1/K", 1.2e-5, "1/K");
}

TEST(Quantities, WithoutAProperNumberAreRefused) {
  for (const char* text : {"", "mm", "nan K", "inf K", "--1"}) {
    EXPECT_EQ(refusal([&] { split_quantity(text); }), std::string("'") + text + "' does not start with a number");
  }
  for (const char* text : {"1,5 mm", "1.2.3 m", "3 4 m"}) {
    EXPECT_EQ(refusal([&] { split_quantity(text); }),
              std::string("'") + text + "' is not one number and a unit; decimals follow a point");
  }
  EXPECT_EQ(refusal([] { split_quantity("1e999 m"); }), "the number in '1e999 m' is out of range");
}

}  // namespace
}  // namespace calor
