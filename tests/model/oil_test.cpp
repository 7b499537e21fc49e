#include "model/oil.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace servohil::model {
namespace {

constexpr double kPsiPerPascal = 1.0 / 6894.757;

double Modulus(const OilParameters& oil, double liquid_psi, double p_psi) {
  return 1.0 / OilModulus(oil, liquid_psi).Compressibility(p_psi);
}

TEST(OilModulus, IsTheLiquidsWithoutAir) {
  // The nuclei take 0.4 % off at 5.7 psi gauge and less than 0.02 % at the working pressure of 103 psi.
  EXPECT_NEAR(Modulus({}, 110'000.0, 103.0) / 110'000.0, 1.0, 2e-4);
  EXPECT_NEAR(Modulus({}, 110'000.0, 5.7) / 110'000.0, 1.0, 5e-3);
}

TEST(OilModulus, HasThePublishedCheckPoints) {
  // Liquid 1.4 GPa, 1 MPa gauge, isothermal, air as gas-to-liquid volume ratio at atmospheric pressure:
  // mixture to liquid 0.631 at 0.5 %, 0.147 at 5 % (no vapour in that formula).
  OilParameters oil;
  oil.vapour_pressure_psi = 0.0;
  const double liquid_psi = 1.4e9 * kPsiPerPascal;
  oil.air_fraction = 0.005;
  EXPECT_NEAR(Modulus(oil, liquid_psi, 1e6 * kPsiPerPascal) / liquid_psi, 0.631, 5e-4);
  oil.air_fraction = 0.05;
  EXPECT_NEAR(Modulus(oil, liquid_psi, 1e6 * kPsiPerPascal) / liquid_psi, 0.147, 5e-4);
}

TEST(OilModulus, AdiabaticAirIsStifferByItsIndex) {
  OilParameters oil;
  oil.air_fraction = 0.2;  // so much that the liquid does not matter: K -> n (1 + V_g)/V_g P
  oil.vapour_pressure_psi = 0.0;
  const double isothermal = Modulus(oil, 1e9, 0.0);
  oil.air_polytropic_index = 1.4;
  EXPECT_NEAR(Modulus(oil, 1e9, 0.0) / isothermal, 1.4, 1e-6);
}

TEST(OilModulus, DissolvedAirNoLongerCounts) {
  OilParameters oil;
  oil.air_fraction = 0.02;
  oil.dissolution_pressure_psi = 200.0;
  EXPECT_NEAR(Modulus(oil, 110'000.0, 190.0) / 110'000.0, 1.0, 2e-4);  // 204.7 psi absolute
  OilParameters never = oil;
  never.dissolution_pressure_psi = 0.0;
  EXPECT_LT(Modulus(oil, 110'000.0, 100.0), Modulus(never, 110'000.0, 100.0))
      << "dissolving is compliance, too";
}

TEST(OilModulus, IsPositiveAndContinuousFromVapourToWorkingPressure) {
  for (const double air : {0.0, 0.001, 0.05}) {
    for (const double dissolution : {0.0, 150.0}) {
      OilParameters oil;
      oil.air_fraction = air;
      oil.dissolution_pressure_psi = dissolution;
      const OilModulus modulus(oil, 110'000.0);
      double last = modulus.Compressibility(modulus.LowestPsi() + 1e-3);
      for (double p = modulus.LowestPsi() + 1e-3; p < 400.0; p += 1e-3 * (p - modulus.LowestPsi())) {
        const double c = modulus.Compressibility(p);
        ASSERT_GT(c, 0.0);
        ASSERT_LT(std::fabs(c - last), 0.02 * last)
            << "no jump within 0.1 % of the distance, at " << p << " psi";
        last = c;
      }
    }
  }
}

TEST(OilModulus, VanishesAtVapourPressure) {
  const OilModulus modulus({}, 110'000.0);
  EXPECT_LT(1.0 / modulus.Compressibility(modulus.LowestPsi() + 1e-5), 1e-3);
  EXPECT_TRUE(std::isnan(modulus.Compressibility(std::nan(""))));
}

TEST(OilAt, PassesThroughTheOilsPoints) {
  OilParameters oil;
  oil.name = OilName::kIsoVg32;
  const auto kinematic_cst = [&](double celsius) {
    oil.temperature_c = celsius;
    const Oil at = OilAt(oil);
    return at.viscosity_lbf_s_in2 / at.density_lbf_s2_in4 * 645.16;  // in²/s to mm²/s
  };
  EXPECT_NEAR(kinematic_cst(40.0), 32.0, 0.01) << "ISO 3448: VG 32";
  EXPECT_NEAR(kinematic_cst(100.0), 5.4, 0.01);
  EXPECT_GT(kinematic_cst(0.0), 200.0) << "cold oil is thick";
  oil.temperature_c = 15.0;
  EXPECT_NEAR(OilAt(oil).density_lbf_s2_in4, 865.0 / 1.0686895e7, 1e-12);
}

TEST(OilAt, CustomIsWhatWasGiven) {
  const Oil oil = OilAt({});
  EXPECT_EQ(oil.density_lbf_s2_in4, 8.0e-5);
  EXPECT_EQ(oil.viscosity_lbf_s_in2, 2.2e-6);
}

}  // namespace
}  // namespace servohil::model
