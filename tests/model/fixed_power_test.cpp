#include "model/fixed_power.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace servohil::model {
namespace {

TEST(FixedPower, IsStdPowToAPartIn1e13) {
  // The series leaves 7/257⁶ = 2.4e-14 of it, rounding of its six factors a few 1e-16 each.
  for (const double q : {-2.0, -1.0 - 1.0 / 1.4, -1.5, 1.0 / 1.4, 1.0, 2.0}) {
    const FixedPower power(q);
    double worst = 0.0;
    for (double x = 1e-8; x < 1e8; x *= 1.00037) {
      const double exact = std::pow(x, q);
      worst = std::max(worst, std::fabs(power(x) - exact) / exact);
    }
    EXPECT_LT(worst, 1e-13) << "q = " << q;
  }
}

TEST(FixedPower, JumpsBetweenItsPartsByRoundingOnly) {
  const FixedPower power(-1.7);
  for (int octave = -3; octave < 9; ++octave) {
    for (int part = 0; part < 128; ++part) {
      const double edge = std::ldexp(1.0 + part / 128.0, octave);
      const double below = std::nextafter(edge, 0.0);
      EXPECT_NEAR(power(edge) / power(below), 1.0, 1e-13) << edge;
    }
  }
}

TEST(FixedPower, BeyondItsTablesItIsStdPow) {
  const FixedPower power(-1.7);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(power(0.0), kInfinity);
  EXPECT_EQ(power(kInfinity), 0.0);
  EXPECT_TRUE(std::isnan(power(-1.0)));
  EXPECT_TRUE(std::isnan(power(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(power(1e-12), std::pow(1e-12, -1.7));
}

}  // namespace
}  // namespace servohil::model
