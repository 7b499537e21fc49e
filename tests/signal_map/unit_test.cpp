#include "signal_map/unit.hpp"

#include <gtest/gtest.h>

namespace servohil::signal_map {
namespace {

double Converted(double value, const char* from, const char* to) {
  const auto conversion = Conversion(from, to);
  return conversion ? (*conversion)(value) : -1e9;
}

TEST(Unit, ConversionsAreThePublishedOnes) {
  // NIST SP 811, appendix B.8: 1 psi = 6894.757 Pa, 1 kgf/cm² = 98066.5 Pa, 1 in = 25.4 mm.
  EXPECT_NEAR(Converted(1.0, "psi", "Pa"), 6894.757, 5e-4);
  EXPECT_NEAR(Converted(1.0, "kgf/cm2", "Pa"), 98066.5, 1e-8);
  EXPECT_NEAR(Converted(1.0, "bar", "psi"), 14.5037738, 5e-8);
  EXPECT_NEAR(Converted(250.0, "kPa", "bar"), 2.5, 1e-12);
  EXPECT_NEAR(Converted(1.0, "MPa", "psi"), 145.037738, 5e-7);
  EXPECT_NEAR(Converted(8.0, "in", "mm"), 203.2, 1e-12);
  EXPECT_NEAR(Converted(2.0, "in/s", "m/s"), 0.0508, 1e-15);
  EXPECT_NEAR(Converted(1500.0, "ms", "s"), 1.5, 1e-12);
}

TEST(Unit, AbsolutePressuresAreAnAtmosphereAbove) {
  EXPECT_NEAR(Converted(0.0, "psi", "psia"), 14.696, 1e-12);
  EXPECT_NEAR(Converted(1.01325, "bara", "psi"), 0.0, 1e-4);
  EXPECT_NEAR(Converted(1.0, "barg", "bar(a)"), 2.01325, 1e-5);
}

TEST(Unit, ThereAndBackIsTheSame) {
  for (const char* const unit : {"bar", "kPa", "MPa", "kgf/cm2", "bara", "mbar"})
    EXPECT_NEAR(Converted(Converted(30.26, "psi", unit), unit, "psi"), 30.26, 1e-12) << unit;
}

TEST(Unit, TheSameUnitChangesNoBit) {
  EXPECT_TRUE(Conversion("psi", "psi")->IsIdentity());
  EXPECT_TRUE(Conversion("psi", "psig")->IsIdentity());
  EXPECT_TRUE(Conversion("furlong", "furlong")->IsIdentity());
  EXPECT_TRUE(Conversion("", "1")->IsIdentity());
}

TEST(Unit, WhatDoesNotMeasureTheSameIsNotConverted) {
  EXPECT_FALSE(Conversion("psi", "mm"));
  EXPECT_FALSE(Conversion("in", "in/s"));
  EXPECT_FALSE(Conversion("psi", ""));
  EXPECT_FALSE(Conversion("%", "in"));
  EXPECT_FALSE(Conversion("mPa", "psi")) << "a millipascal is no megapascal";
  EXPECT_EQ(ConvertibleUnits("in"), "in, mm, cm, m, um");
  EXPECT_EQ(ConvertibleUnits("furlong"), "");
}

}  // namespace
}  // namespace servohil::signal_map
