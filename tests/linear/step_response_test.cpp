#include "linear/step_response.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace servohil::linear {
namespace {

/// x3'' + 2 zeta w x3' + w² x3 = gain w² u
LinearSystem SecondOrder(double zeta, double w, double gain) {
  LinearSystem s{LinearMatrix(2, 2), LinearVector(2)};
  s.A << 0.0, 1.0, -w * w, -2.0 * zeta * w;
  s.B << 0.0, gain * w * w;
  return s;
}

TEST(StepResponse, IsExactAtItsSamples) {
  const double zeta = 0.1;
  const double w = 300.0;
  StepResponse response(SecondOrder(zeta, w, 2.0), 1e-3);
  const double wd = w * std::sqrt(1.0 - zeta * zeta);
  for (int i = 1; i <= 100; ++i) {
    response.Advance();
    const double t = i * 1e-3;
    const double exact =
        2.0 * (1.0 - std::exp(-zeta * w * t) * (std::cos(wd * t) + zeta * w / wd * std::sin(wd * t)));
    EXPECT_NEAR(response.Now()[0], exact, 1e-11) << "rounding of up to 100 products";
  }
}

TEST(StepFigures, OfAFirstOrderLag) {
  LinearSystem lag{LinearMatrix(1, 1), LinearVector(1)};
  lag.A << -20.0;
  lag.B << 10.0;
  const StepFigures f = FindStepFigures(lag);
  EXPECT_NEAR(f.final_in_psi, 0.5, 1e-12);
  EXPECT_NEAR(f.rise_s, std::log(20.0) / 20.0, 1e-4 * f.rise_s);          // 1 - e^-20t = 0.95
  EXPECT_NEAR(f.settling_s, std::log(50.0) / 20.0, 1e-4 * f.settling_s);  // 0.98
  EXPECT_EQ(f.overshoot, 0.0);
}

TEST(StepFigures, OvershootOfASecondOrderSystem) {
  const double zeta = 0.2;
  const StepFigures f = FindStepFigures(SecondOrder(zeta, 50.0, 1.0));
  EXPECT_NEAR(f.overshoot, std::exp(-M_PI * zeta / std::sqrt(1.0 - zeta * zeta)), 1e-4);
}

TEST(StepFigures, AnUnstableSystemHasNone) {
  const StepFigures f = FindStepFigures(SecondOrder(-0.01, 1000.0, 1.0));
  EXPECT_TRUE(std::isnan(f.final_in_psi));
  EXPECT_TRUE(std::isnan(f.rise_s));
}

}  // namespace
}  // namespace servohil::linear
