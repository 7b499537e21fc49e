#include "model/step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "model/servomotor.hpp"
#include "model/steady_state.hpp"
#include "nominal.hpp"

namespace servohil::model {
namespace {

TEST(Step, RestsAtTheSteadyState) {
  const Derived d(testing::Nominal());
  const SteadyState start = SteadyStateAt(d, 4.0);
  State s = start.state;
  for (int i = 0; i < 1000; ++i) s = Step(d, s, start.p1_psi).state;
  EXPECT_NEAR(s.x3_in, 4.0, 1e-12);  // rounding only; the nominal servo is stable
}

TEST(Step, BelowBreakawayThePistonDoesNotMoveAtAll) {
  const Derived d(testing::WithFriction(5.0));
  const SteadyState start = SteadyStateAt(d, 4.0);
  State s = start.state;
  const double p1 = start.p1_psi + 1e-4;  // shifts P3 by less than 5 psi
  for (int i = 0; i < 100'000; ++i) {     // 10 s
    s = Step(d, s, p1).state;
    ASSERT_EQ(s.mode.motion, Motion::kStuck) << "tick " << i;
  }
  EXPECT_EQ(s.x3_in, 4.0) << "stuck is exact: not 1e-9 in, nothing";
  EXPECT_NE(s.p3_psi, start.state.p3_psi) << "the pressure did follow";
}

TEST(Step, BreaksAwayWhereTheDriveReachesTheFrictionLevel) {
  const Derived d(testing::WithFriction(5.0));
  const SteadyState start = SteadyStateAt(d, 4.0);
  State before = start.state;
  State after = before;
  for (int i = 0; i < 10'000 && after.mode.motion == Motion::kStuck; ++i) {
    before = std::exchange(after, Step(d, after, start.p1_psi + 0.27).state);
  }
  ASSERT_EQ(after.mode.motion, Motion::kUp);
  EXPECT_LE(before.p3_psi, 108.0);  // 103 + B
  EXPECT_GT(after.p3_psi, 108.0);
  EXPECT_GE(after.v3_in_s, 0.0);
}

TEST(Step, FrictionNeverDrives) {
  // Large forced motion with stops and reversals: friction power B A3 sgn(v) v is never negative, and the
  // stuck piston's velocity is exactly zero.
  const Derived d(testing::WithFriction(10.0));
  const SteadyState start = SteadyStateAt(d, 4.5);
  State s = start.state;
  int stops = 0;
  int reversals = 0;
  Motion last_sliding = Motion::kStuck;
  for (int i = 0; i < 30'000; ++i) {
    const double t = i * kTickS;
    const Motion was = s.mode.motion;
    s = Step(d, s, start.p1_psi + 1.5 * std::sin(2.0 * std::numbers::pi * 2.0 * t)).state;
    switch (s.mode.motion) {
      case Motion::kUp:
        ASSERT_GE(s.v3_in_s, 0.0);
        break;
      case Motion::kDown:
        ASSERT_LE(s.v3_in_s, 0.0);
        break;
      case Motion::kStuck:
        ASSERT_EQ(s.v3_in_s, 0.0);
        break;
      case Motion::kAtLowerStop:
      case Motion::kAtUpperStop:
        FAIL() << "the thesis has no stops";
      case Motion::kFree:
        FAIL() << "with friction there is always a direction";
    }
    if (s.mode.motion == Motion::kStuck && was != Motion::kStuck) ++stops;
    if (s.mode.motion != Motion::kStuck) {
      if (last_sliding != Motion::kStuck && s.mode.motion != last_sliding) ++reversals;
      last_sliding = s.mode.motion;
    }
  }
  EXPECT_GE(reversals, 11) << "2 Hz over 3 s turns 12 times, perhaps not the last one";
  // A 2 Hz sweep halts at each turn; chatter would add hundreds.
  EXPECT_GE(stops, 11);
  EXPECT_LE(stops, 60);
}

TEST(Step, StickingTimesConvergeWithTheStep) {
  // Event places are exact to the order of the method, so that a tenth of the step changes nothing visible.
  const Derived d(testing::WithFriction(10.0));
  const SteadyState start = SteadyStateAt(d, 4.5);
  const auto x3_after = [&](int parts) {
    State s = start.state;
    for (int i = 0; i < 5'000; ++i) {
      const double p1 = start.p1_psi + 1.5 * std::sin(2.0 * std::numbers::pi * 2.0 * i * kTickS);
      for (int k = 0; k < parts; ++k) s = Step(d, s, p1, kTickS / parts).state;
    }
    return s.x3_in;
  };
  EXPECT_NEAR(x3_after(1), x3_after(10), 1e-5);
}

TEST(Step, IsTheSameEveryTime) {
  const Derived d(testing::WithFriction(5.0));
  const SteadyState start = SteadyStateAt(d, 3.2);  // the load jump at 3.35 in is crossed
  State a = start.state;
  State b = start.state;
  for (int i = 0; i < 5'000; ++i) a = Step(d, a, start.p1_psi + 2.0).state;
  for (int i = 0; i < 5'000; ++i) b = Step(d, b, start.p1_psi + 2.0).state;
  EXPECT_EQ(a.Vector(), b.Vector());
}

TEST(Step, WithoutStabilizerP8IsP3) {
  const Derived d(testing::Nominal());
  const SteadyState start = SteadyStateAt(d, 4.0);
  State s = start.state;
  for (int i = 0; i < 1'000; ++i) s = Step(d, s, start.p1_psi + 1.0).state;
  EXPECT_EQ(s.p8_psi, s.p3_psi);
}

TEST(Step, TakesTheSubStepsThatTheFastestModeNeeds) {
  const Derived d(testing::Nominal());
  const SteadyState start = SteadyStateAt(d, 7.2);
  EXPECT_EQ(Step(d, start.state, start.p1_psi).sub_steps, 1) << "working point: 1,100 rad/s";
  // -5 psi throws the relay port open and P4 falls to 0.02 psi, where it follows at 5e4 1/s: 5 sub-steps.
  State s = start.state;
  int most = 0;
  for (int i = 0; i < 1'000; ++i) {
    const StepResult result = Step(d, s, start.p1_psi - 5.0);
    EXPECT_TRUE(result.resolved);
    EXPECT_LE(RatesAndScalesAt(d, s, start.p1_psi - 5.0).scales.FastestMode() * kTickS / result.sub_steps,
              0.5);
    most = result.sub_steps > most ? result.sub_steps : most;
    s = result.state;
  }
  EXPECT_GE(most, 8);
  EXPECT_LE(most, 16);
}

TEST(Step, SaysWhereSubStepsAreNotEnough) {
  const Derived d(testing::Nominal());
  State s = SteadyStateAt(d, 4.0).state;
  s.p4_psi = 0.0;  // an orifice at dP = 0 is infinitely fast
  const StepResult result = Step(d, s, 30.0);
  EXPECT_FALSE(result.resolved);
  EXPECT_TRUE(IsInDomain(d, result.state));
}

TEST(IsInDomain, RefusesWhatTheEquationsCannotMean) {
  Parameters p = testing::Nominal();
  State s = SteadyStateAt(Derived(p), 4.0).state;
  EXPECT_TRUE(IsInDomain(Derived(p), s));
  State bad = s;
  bad.x3_in = -0.39;  // V3 = 30 + 78.4 x3 < 0
  EXPECT_FALSE(IsInDomain(Derived(p), bad));
  bad = s;
  bad.p4_psi = std::nan("");
  EXPECT_FALSE(IsInDomain(Derived(p), bad));
  bad = s;
  bad.p8_psi = -1.0;
  EXPECT_TRUE(IsInDomain(Derived(p), bad)) << "no stabilizer, no gas";
  p.stabilizer.enabled = true;
  EXPECT_FALSE(IsInDomain(Derived(p), bad));
}

}  // namespace
}  // namespace servohil::model
