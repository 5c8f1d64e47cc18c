// Contacts whose conductance changes with temperature and time.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "case_models.hpp"

namespace calor {
namespace {

constexpr const char* methods[] = {"sph", "peridynamics", "mlpg"};

/// Steel of 10 mm and wool of 50 mm, 1 m^2, with a contact between them.
std::string steel_and_wool(const std::string& method, int points, const std::string& contact,
                           const std::string& when = "[steady]\n") {
  const std::string rest = when == "[steady]\n" ? "" : "density = \"1000 kg/m^3\"\nspecific_heat = \"500 J/(kg K)\"\n";
  return box_case({"60 mm"}, {points}, method) +
         fmt::format(
             "[material.steel]\nconductivity = \"40 W/(m K)\"\n{0}[material.wool]\nconductivity = \"0.1 W/(m K)\"\n{0}"
             "[body]\nalong = \"x\"\n[[body.layer]]\nmaterial = \"steel\"\nthickness = \"10 mm\"\n"
             "[[body.layer]]\nmaterial = \"wool\"\nthickness = \"50 mm\"\n"
             "contact = {{ formula = \"{1}\", unit = \"W/(m^2 K)\" }}\n",
             rest, contact) +
         when;
}

TEST(Contacts, OfTemperatureTakeTheMeanOfTheirFacesWhereverTheyLieBetweenPoints) {
  // q = h(T) (T_- - T_+), T = (T_- + T_+) / 2, T_- = 1000 K - q 0.01/40, T_+ = 300 K + q 0.05/0.1 m^2 K/W, by
  // bisection.
  const std::string walls = "[boundary.xmin]\ntemperature = \"1000 K\"\n[boundary.xmax]\ntemperature = \"300 K\"\n";
  for (const auto& [contact, flow] :
       {std::pair{"4*0.05*5.67e-8*T^3", 1153.1067551180358}, {"4*0.02*5.67e-8*T^3", 820.7701691232443}})
    for (const char* method : methods)
      for (const int points : {7, 8, 13, 14}) {  // the contact lies on a point for 7 and 13
        SCOPED_TRACE(fmt::format("{}, {} points, {}", method, points, contact));
        const CaseModel m(steel_and_wool(method, points, contact) + walls);
        State state = m.steady();
        EXPECT_NEAR(m.system().heat_flows(0, state.T)[0], flow, 1e-7 * flow);
      }
}

TEST(Contacts, OfTimeConductAsTheyDoAtThatTime) {
  // Temperatures of 1000 W straight through, for a contact of h; of 0 W where h is 0.
  const std::string rest = "[initial]\ntemperature = \"500 K\"\n[time]\nend = \"10 s\"\n";
  for (const char* method : methods) {
    SCOPED_TRACE(method);
    const CaseModel m(steel_and_wool(method, 16, "t < 3 ? 0 : 50 + 10*t", rest));
    for (const auto& [t, h] : {std::pair{0., 0.}, {5., 100.}, {2., 0.}, {10., 150.}}) {
      const double q = h > 0 ? 1000 : 0, behind = h > 0 ? 700 - q * 0.01 / 40 - q / h : 400;
      std::vector<double> T;
      for (const Vec3& x : m.cloud().x) T.push_back(x.x < 0.01 ? 700 - q * x.x / 40 : behind - q * (x.x - 0.01) / 0.1);
      const Rates rates = m.rates(t, T);
      double into_wool = 0;
      for (int i = 0; i < m.cloud().owned; ++i)
        if (m.cloud().x[i].x > 0.01) into_wool += rates.F[i];
      EXPECT_NEAR(into_wool, q, 1e-9 * 1000) << t;
    }
    // Steps land on the time at which it closes.
    const Changes& changes = m.system().changes();
    EXPECT_TRUE(std::ranges::any_of(changes.events, [](double t) { return std::abs(t - 3) < 1e-6; }));
    EXPECT_FALSE(m.system().jacobian_is_constant());
    EXPECT_TRUE(m.system().jacobian_is_symmetric());
  }
  EXPECT_FALSE(CaseModel(steel_and_wool("sph", 16, "1 + 0.1*T", rest)).system().jacobian_is_symmetric());
}

TEST(Contacts, OfTimeAreRefusedWhereTheyBecomeNegative) {
  const std::string rest = "[initial]\ntemperature = \"500 K\"\n[time]\nend = \"10 s\"\n";
  const CaseModel m(steel_and_wool("sph", 16, "50 - 10*t", rest));
  expect_error([&] { (void)m.rates(6, m.uniform(500)); },
               {"test.toml:", "a contact of -10 W/(m^2 K), t = 6 s is negative", "give 0"}, Fault::numbers);
}

}  // namespace
}  // namespace calor
