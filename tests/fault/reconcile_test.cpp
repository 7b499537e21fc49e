#include "model/reconcile.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace servohil::fault {
namespace {

using testing::Full;
using testing::WithStabilizer;

model::Parameters WithCoulomb(double psi) {
  model::Parameters p = testing::Full();
  p.friction.coulomb_psi = psi;
  return p;
}

model::State AtRest(const model::Parameters& p) {
  return model::SteadyStateAt(model::Derived(p), 4.0).state;
}

model::State Moving(double v3_in_s, double p3_psi = 110.0) {
  model::State s = AtRest(testing::Full());
  s.v3_in_s = v3_in_s;
  s.p3_psi = p3_psi;
  s.p8_psi = p3_psi;
  return s;
}

TEST(Reconciled, KeepsWhatOilAndMassKeep) {
  model::Parameters p = WithCoulomb(15.0);
  p.supply.pressure_psi = 250.0;
  p.cam.x3_star_in += 0.1;
  const model::State before = Moving(-3.0);
  const model::State after = model::Reconciled(model::Derived(p), before, 30.0);
  EXPECT_EQ(after.x3_in, before.x3_in);
  EXPECT_EQ(after.v3_in_s, before.v3_in_s);
  EXPECT_EQ(after.p3_psi, before.p3_psi);
  EXPECT_EQ(after.p4_psi, before.p4_psi);
  EXPECT_EQ(after.p2_psi, 250.0) << "a constant supply has its new pressure";
  p.supply.pump_flow_in3_s = 100.0;
  EXPECT_EQ(model::Reconciled(model::Derived(p), before, 30.0).p2_psi, before.p2_psi)
      << "an accumulator keeps its own";
}

TEST(Reconciled, DoesNotChangeAStateOfTheSameParameters) {
  for (const model::Parameters& p : {testing::Full(), WithCoulomb(15.0), testing::WithStabilizer()}) {
    testing::Bench bench(p);
    for (double p1_psi : {60.0, 10.0, 300.0, 0.0}) {
      bench.p1_psi = p1_psi;
      for (int i = 0; i < 50; ++i) {
        const model::State s = bench.Run(10).state;
        const model::State same = model::Reconciled(model::Derived(p), s, p1_psi);
        ASSERT_EQ(same.Vector(), s.Vector());
        ASSERT_EQ(same.mode.motion, s.mode.motion);
        ASSERT_EQ(same.mode.plunger, s.mode.plunger);
        ASSERT_EQ(same.mode.diaphragm_seated, s.mode.diaphragm_seated);
      }
    }
  }
}

TEST(Reconciled, FrictionThatAppearsActsAgainstTheMotion) {
  const model::Derived d(WithCoulomb(15.0));
  EXPECT_EQ(model::Reconciled(d, Moving(2.0), 30.0).mode.motion, model::Motion::kUp);
  EXPECT_EQ(model::Reconciled(d, Moving(-2.0), 30.0).mode.motion, model::Motion::kDown);
  // At 4 in the load is 103 psi: what P3 leaves of 15 psi decides.
  EXPECT_EQ(model::Reconciled(d, Moving(0.0, 110.0), 30.0).mode.motion, model::Motion::kStuck);
  EXPECT_EQ(model::Reconciled(d, Moving(0.0, 119.0), 30.0).mode.motion, model::Motion::kUp);
  EXPECT_EQ(model::Reconciled(d, Moving(0.0, 87.0), 30.0).mode.motion, model::Motion::kDown);
}

TEST(Reconciled, FrictionThatDisappearsLeavesThePistonFree) {
  model::State s = Moving(0.0);
  s.mode.motion = model::Motion::kStuck;
  EXPECT_EQ(model::Reconciled(model::Derived(testing::Full()), s, 30.0).mode.motion, model::Motion::kFree);
  s = Moving(-2.0);
  s.mode.motion = model::Motion::kDown;
  EXPECT_EQ(model::Reconciled(model::Derived(testing::Full()), s, 30.0).mode.motion, model::Motion::kFree);
}

TEST(Reconciled, APistonOnItsStopStaysThere) {
  model::State s = Moving(0.0);
  s.mode.motion = model::Motion::kAtUpperStop;
  EXPECT_EQ(model::Reconciled(model::Derived(WithCoulomb(15.0)), s, 30.0).mode.motion,
            model::Motion::kAtUpperStop);
  EXPECT_EQ(model::Reconciled(model::Derived(testing::Full()), s, 30.0).mode.motion,
            model::Motion::kAtUpperStop);
}

TEST(Reconciled, AStabilizerThatIsGoneHasThePressureUnderThePiston) {
  model::State s = AtRest(testing::WithStabilizer());
  s.p3_psi = 120.0;
  const model::State gone = model::Reconciled(model::Derived(testing::Full()), s, 30.0);
  EXPECT_EQ(gone.p8_psi, 120.0);
  const model::State back = model::Reconciled(model::Derived(testing::WithStabilizer()), gone, 30.0);
  EXPECT_EQ(back.p8_psi, 120.0);
  EXPECT_FALSE(back.mode.diaphragm_seated);
}

TEST(Reconciled, ADiaphragmSeatsBelowItsPrecharge) {
  model::State s = AtRest(testing::WithStabilizer());
  s.p8_psi = 15.0;
  EXPECT_TRUE(model::Reconciled(model::Derived(testing::WithStabilizer()), s, 30.0).mode.diaphragm_seated);
  model::Parameters lost = testing::WithStabilizer();
  lost.stabilizer.precharge_psi = 10.0;
  EXPECT_FALSE(model::Reconciled(model::Derived(lost), s, 30.0).mode.diaphragm_seated);
}

TEST(Reconciled, APlungerBeyondItsStopsIsOnThem) {
  // Stops at P4 = (13.5 ± 0.25 k2)/2.341 psi: 28.4 psi with 212 lbf/in, 17.1 psi with half of it.
  model::State s = AtRest(testing::Full());
  s.p4_psi = 20.0;
  EXPECT_EQ(model::Reconciled(model::Derived(testing::Full()), s, 30.0).mode.plunger, model::Plunger::kFree);
  model::Parameters weak = testing::Full();
  weak.servo.main_spring_rate_lbf_in = 106.0;
  const model::State on_stop = model::Reconciled(model::Derived(weak), s, 30.0);
  EXPECT_EQ(on_stop.mode.plunger, model::Plunger::kAtUpperStop);
  EXPECT_EQ(on_stop.p4_psi, 20.0) << "the oil's pressure stays";
  EXPECT_EQ(model::Reconciled(model::Derived(testing::Full()), on_stop, 30.0).mode.plunger,
            model::Plunger::kFree);
}

TEST(Reconciled, TheRelayPortIsFullBeyondItsHeight) {
  const model::State s = AtRest(testing::Full());
  EXPECT_FALSE(model::Reconciled(model::Derived(testing::Full()), s,
                                 model::SteadyStateAt(model::Derived(testing::Full()), 4.0).p1_psi)
                   .mode.relay_port_full);
  EXPECT_TRUE(model::Reconciled(model::Derived(testing::Full()), s, 0.0).mode.relay_port_full)
      << "x1 = 0 leaves it open by inches";
}

}  // namespace
}  // namespace servohil::fault
