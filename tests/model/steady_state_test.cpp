#include "model/steady_state.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "nominal.hpp"

namespace servohil::model {
namespace {

TEST(SteadyState, IsTheExactOneOfTheReference) {
  const Derived d(testing::Nominal());
  const SteadyState s = SteadyStateAt(d, 4.0);
  ASSERT_TRUE(s);
  // expected.md, row "exact", to the digits shown there.
  EXPECT_NEAR(s.outputs.x1_in, 4.142101, 5e-7);
  EXPECT_NEAR(s.outputs.x2_in, 4.179340, 5e-7);
  EXPECT_NEAR(s.outputs.x4_in, 4.180000, 5e-7);
  EXPECT_NEAR(s.p1_psi, 30.26320, 5e-6);
  EXPECT_NEAR(s.state.p3_psi, 103.000, 5e-4);
  EXPECT_NEAR(s.state.p4_psi, 5.70702, 5e-6);
  EXPECT_NEAR(s.outputs.q4_in3_s, 48.4026, 5e-5);
}

TEST(SteadyState, LeavesNoRateOverTheWholeStroke) {
  for (const CamShape shape : {CamShape::kSingle, CamShape::kTwoSlope}) {
    Parameters p = testing::Nominal();
    p.cam.shape = shape;
    p.stabilizer.enabled = true;
    const Derived d(p);
    for (double x3 = 0.0; x3 <= 8.0; x3 += 0.01) {
      const SteadyState s = SteadyStateAt(d, x3);
      ASSERT_TRUE(s) << "x3 = " << x3;
      const StateVector rate = Rates(d, s.state.Vector(), Motion::kFree, s.p1_psi);
      // Flows of 50 in³/s balance to rounding (1e-13); beta/V3 (up to 3700 psi/in³) makes 1e-9 psi/s of it.
      EXPECT_LT(std::fabs(rate[kP3]), 1e-6) << "x3 = " << x3;
      EXPECT_LT(std::fabs(rate[kP4]), 1e-6) << "x3 = " << x3;
      EXPECT_EQ(rate[kX3], 0.0);
      EXPECT_NEAR(rate[kV3], 0.0, 1e-9);
    }
  }
}

TEST(SteadyState, ForP1FindsThePositionAgain) {
  const Derived d(testing::Nominal());
  for (double x3 = 0.0; x3 <= 8.0; x3 += 0.37) {
    const SteadyState s = SteadyStateForP1(d, SteadyStateAt(d, x3).p1_psi);
    ASSERT_TRUE(s) << "x3 = " << x3;
    EXPECT_NEAR(s.state.x3_in, x3, 1e-11) << "P1 resolves x3 to rounding";
  }
}

TEST(SteadyState, SaysWhyThereIsNone) {
  Parameters p = testing::Nominal();
  EXPECT_EQ(SteadyStateForP1(Derived(p), 80.0).error, SteadyStateError::kNoPositionForP1);
  EXPECT_EQ(SteadyStateForP1(Derived(p), 1.0).error, SteadyStateError::kNoPositionForP1);
  p.supply.pressure_psi = 100.0;  // the load at 4 in needs 103 psi
  EXPECT_EQ(SteadyStateAt(Derived(p), 4.0).error, SteadyStateError::kLoadAboveSupply);
  p = testing::Nominal();
  p.servo.relay_piston_clearance_in = 0.2;  // passes Q4 = 48.4 in³/s at 0.037 in already
  EXPECT_EQ(SteadyStateAt(Derived(p), 4.0).error, SteadyStateError::kRelayPortTooOpen);
}

TEST(SteadyState, AtRestUnderFrictionThePistonIsStuck) {
  EXPECT_EQ(SteadyStateAt(Derived(testing::Nominal()), 4.0).state.mode.motion, Motion::kFree);
  EXPECT_EQ(SteadyStateAt(Derived(testing::WithFriction(5.0)), 4.0).state.mode.motion, Motion::kStuck);
}

}  // namespace
}  // namespace servohil::model
