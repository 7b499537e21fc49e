#include "linear/margins.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "linear/linearization.hpp"
#include "model/nominal.hpp"

namespace servohil::linear {
namespace {

TEST(Margins, OfATextbookLoop) {
  // L = 4 / (s + 1)³: phase -180° at sqrt(3) rad/s, |L| = 1/2 there; |L| = 1 at sqrt(4^(2/3) - 1).
  const Margins m = FindMargins({{4.0}, Polynomial{1.0, 1.0} * Polynomial{1.0, 1.0} * Polynomial{1.0, 1.0}});
  ASSERT_EQ(m.gain_limit_count, 1);
  EXPECT_NEAR(m.Upper(), 2.0, 1e-9);
  EXPECT_EQ(m.Lower(), 0.0);
  EXPECT_NEAR(m.gain_limits[0].frequency_rad_s, std::sqrt(3.0), 1e-9);
  const double w = std::sqrt(std::pow(4.0, 2.0 / 3.0) - 1.0);
  ASSERT_NE(m.Phase(), nullptr);
  EXPECT_NEAR(m.Phase()->frequency_rad_s, w, 1e-9);
  EXPECT_NEAR(m.Phase()->margin_deg, 180.0 - 3.0 * std::atan(w) * 180.0 / M_PI, 1e-7);
}

TEST(Margins, AnUnstablePlantNeedsALeastGain) {
  // L = 3 / (s - 1): closed loop s + 2; at a third of the gain its pole is at 0.
  const Margins m = FindMargins({{3.0}, {1.0, -1.0}});
  ASSERT_EQ(m.gain_limit_count, 1);
  EXPECT_NEAR(m.Lower(), 1.0 / 3.0, 1e-12);
  EXPECT_EQ(m.Upper(), 0.0);
}

TEST(PositionLoop, OnePlusItIsClosedOverOpen) {
  for (const bool stabilizer : {false, true}) {
    model::Parameters p = model::testing::Nominal();
    p.stabilizer.enabled = stabilizer;
    const model::Derived d(p);
    const model::SteadyState rest = model::SteadyStateAt(d, 4.0);
    const LinearSystem closed = Linearize(d, rest).system;
    const LinearSystem open = Linearize(model::Derived(WithBushingHeld(p, 4.0)), rest).system;
    const TransferFunction loop = PositionLoop(closed, open);
    const Polynomial sum = loop.denominator + loop.numerator;
    const Polynomial denominator = ToTransferFunction(closed).denominator;
    for (int i = 0; i <= denominator.degree; ++i)
      EXPECT_NEAR(sum[i] / denominator[i], 1.0, 1e-9) << "power " << i;
  }
}

TEST(PositionLoop, AtAGainLimitThePolesLieOnTheAxis) {
  const model::Parameters p = model::testing::Nominal();
  const model::Derived d(p);
  const model::SteadyState rest = model::SteadyStateAt(d, 4.0);
  const LinearSystem closed = Linearize(d, rest).system;
  const LinearSystem open = Linearize(model::Derived(WithBushingHeld(p, 4.0)), rest).system;
  const Margins m = FindMargins(PositionLoop(closed, open));
  ASSERT_EQ(m.gain_limit_count, 2);
  EXPECT_GT(m.Upper(), 1.0) << "the nominal servo is stable";
  EXPECT_LT(m.Lower(), 1.0);
  for (int i = 0; i < 2; ++i) {
    const GainLimit& limit = m.gain_limits[static_cast<std::size_t>(i)];
    LinearSystem scaled = closed;
    scaled.A = open.A + limit.factor * (closed.A - open.A);
    EXPECT_NEAR(Poles(scaled).LargestRealPart(), 0.0, 1e-6) << "factor " << limit.factor;
  }
}

}  // namespace
}  // namespace servohil::linear
