#include "model/laws.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "nominal.hpp"

namespace servohil::model {
namespace {

TEST(OrificeFlow, OpenPortIsEquation2_5) {
  const Derived d(testing::Nominal());
  // c_d pi d6 sqrt(x² + c²) sqrt(2 dP / rho), straight from the equation: 0.625 pi 3.495 sqrt(...)
  const double expected = 0.625 * 3.14159265358979323846 * 3.495 * std::sqrt(0.003 * 0.003 + 0.002 * 0.002) *
                          std::sqrt(2.0 * 197.0 / 8e-5);
  EXPECT_NEAR(OrificeFlow(197.0, 0.003, 0.002, d.k_metering), expected, 1e-12 * expected);
}

TEST(OrificeFlow, ClosedPortLeaksThroughTheClearanceOnly) {
  const double closed = OrificeFlow(100.0, -0.01, 0.002, 1000.0);
  EXPECT_DOUBLE_EQ(closed, 1000.0 * 0.002 * 10.0);  // k c sqrt(dP)
  EXPECT_DOUBLE_EQ(OrificeFlow(100.0, 0.0, 0.002, 1000.0), closed) << "continuous where the port opens";
  EXPECT_EQ(OrificeFlow(100.0, -0.01, 0.0, 1000.0), 0.0) << "without clearance a closed port is tight";
}

TEST(OrificeFlow, IsOddInThePressureDifference) {
  EXPECT_EQ(OrificeFlow(-7.0, 0.01, 0.002, 1000.0), -OrificeFlow(7.0, 0.01, 0.002, 1000.0));
  EXPECT_EQ(OrificeFlow(0.0, 0.01, 0.002, 1000.0), 0.0);
}

TEST(OrificeFlow, SwallowsNoNaN) {
  EXPECT_TRUE(std::isnan(OrificeFlow(1.0, std::nan(""), 0.002, 1000.0)));
  EXPECT_TRUE(std::isnan(OrificeFlow(std::nan(""), 0.01, 0.002, 1000.0)));
}

TEST(CapillaryFlow, SolvesEquation2_3) {
  const Derived d(testing::Nominal());
  for (const double dP : {1e-9, 1.0, 294.3, 3000.0}) {
    const double Q = CapillaryFlow(dP, d.capillary_a, d.capillary_b);
    EXPECT_NEAR(d.capillary_a * Q * (1.0 + d.capillary_b * Q), dP, 1e-12 * dP) << "dP = " << dP;
  }
}

TEST(CapillaryFlow, IsLaminarWithoutEntranceLossAndOdd) {
  EXPECT_DOUBLE_EQ(CapillaryFlow(5.0, 0.25, 0.0), 20.0);  // Q = dP / a
  EXPECT_EQ(CapillaryFlow(-5.0, 0.25, 0.1), -CapillaryFlow(5.0, 0.25, 0.1));
}

TEST(Derived, ReproducesTheConstantsOfAppendixB) {
  const Derived d(testing::Nominal());
  EXPECT_NEAR(d.A1, 4.106, 5e-4);
  EXPECT_NEAR(d.A3, 78.38, 5e-3);
  EXPECT_NEAR(d.M, 1.669, 5e-4);
  EXPECT_NEAR(d.c3, 1.8575e-4, 5e-9) << "errata 2";
  EXPECT_NEAR(d.C, 0.11047, 5e-6) << "errata 2";
  EXPECT_NEAR(d.capillary_a, 290.1e-3, 5e-5) << "a4 without its factor, errata 13";
}

}  // namespace
}  // namespace servohil::model
