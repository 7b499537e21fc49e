/// The additions of physics "full": each where it acts, and in the limit in which it is the thesis' law.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "model/laws.hpp"
#include "model/servomotor.hpp"
#include "model/steady_state.hpp"
#include "model/step.hpp"
#include "nominal.hpp"

namespace servohil::model {
namespace {

Parameters Full() {
  Parameters p = testing::Nominal();
  p.physics = Physics::kFull;
  return p;
}

/// State after `ticks` at constant P1.
State After(const Derived& d, State s, double p1_psi, int ticks) {
  for (int i = 0; i < ticks; ++i) s = Step(d, s, p1_psi).state;
  return s;
}

TEST(OrificeConductance, DeviatesLessThanAPerMilleFromSixteenTransitionPressuresOn) {
  for (double dP = 15.8; dP < 1e4; dP *= 1.1) {
    const double turbulent = OrificeFlow(dP, 0.01, 0.002, 1000.0);
    const double smooth = dP * OrificeConductance(dP, OpeningSquared(0.01, 0.002, 0.25), 1000.0, 1.0);
    EXPECT_LE(smooth, turbulent);
    EXPECT_GE(smooth, 0.999 * turbulent) << "dP = " << dP << " p_t";
  }
}

TEST(OrificeConductance, IsOddWithFiniteSlopeAtZero) {
  const double a2 = OpeningSquared(0.01, 0.0, 0.25);
  const auto flow = [&](double dP) { return dP * OrificeConductance(dP, a2, 1000.0, 0.1); };
  EXPECT_EQ(flow(-3.0), -flow(3.0));
  EXPECT_EQ(flow(0.0), 0.0);
  EXPECT_NEAR(flow(1e-9) / 1e-9, 1000.0 * 0.01 / std::sqrt(0.1), 1e-6);
}

TEST(Opening, SaturatesAtThePortsHeight) {
  EXPECT_DOUBLE_EQ(OpeningSquared(5.0, 0.0, 0.25), 0.0625);
  EXPECT_DOUBLE_EQ(OpeningSquared(0.25, 0.0, 0.25), 0.0625) << "continuous";
}

TEST(EndStops, AFullStrokeRunsIntoEachStopAndBack) {
  const Derived d(Full());
  const SteadyState start = SteadyStateAt(d, 4.0);
  State s = After(d, start.state, 0.0, 10'000);
  EXPECT_EQ(s.x3_in, 0.0);
  EXPECT_EQ(s.v3_in_s, 0.0);
  EXPECT_EQ(s.mode.motion, Motion::kAtLowerStop);
  s = After(d, s, 60.0, 10'000);
  EXPECT_EQ(s.x3_in, 8.0);
  EXPECT_EQ(s.mode.motion, Motion::kAtUpperStop);
  s = After(d, s, start.p1_psi, 10'000);
  EXPECT_NEAR(s.x3_in, 4.0, 1e-6) << "and leaves it when the pressure no longer holds it there";
}

TEST(EndStops, RestIsExactAndNothingPassesThem) {
  Parameters p = Full();
  p.friction.coulomb_psi = 5.0;
  const Derived d(p);
  State s = SteadyStateAt(d, 0.5).state;
  for (int i = 0; i < 20'000; ++i) {
    s = Step(d, s, i < 10'000 ? 0.0 : 80.0).state;
    ASSERT_GE(s.x3_in, 0.0);
    ASSERT_LE(s.x3_in, 8.0);
  }
  EXPECT_EQ(s.x3_in, 8.0);
}

TEST(Friction, FromRestItTakesBreakawayThenFallsToCoulomb) {
  Parameters p = Full();
  p.friction.coulomb_psi = 5.0;
  p.friction.breakaway_psi = 12.0;
  const Derived d(p);
  const SteadyState start = SteadyStateAt(d, 4.0);
  State s = start.state;
  double before_psi = 0.0;
  while (s.mode.motion == Motion::kStuck) {
    before_psi = s.p3_psi;
    s = Step(d, s, start.p1_psi + 0.5).state;
  }
  EXPECT_LE(before_psi, 103.0 + 12.0);
  EXPECT_GT(s.p3_psi, 103.0 + 12.0);
  s = After(d, s, start.p1_psi + 0.5, 20);
  ASSERT_GT(s.v3_in_s, 2.0);
  EXPECT_NEAR(ComputeOutputs(d, s, start.p1_psi + 0.5).friction_psi, 5.0, 7.0 * 0.01 / 4.0)
      << "(v_s/v)² of 7 psi left";
}

TEST(Friction, ByDirectionAndVelocity) {
  Parameters p = Full();
  p.friction.coulomb_psi = 5.0;
  p.friction.closing_ratio = 0.6;
  p.friction.viscous_psi_s_in = 0.5;
  const Derived d(p);
  State s = SteadyStateAt(d, 4.0).state;
  s.v3_in_s = 2.0;
  s.mode.motion = Motion::kUp;
  EXPECT_NEAR(ComputeOutputs(d, s, 30.0).friction_psi, 5.0 + 1.0, 1e-12);
  s.v3_in_s = -2.0;
  s.mode.motion = Motion::kDown;
  EXPECT_NEAR(ComputeOutputs(d, s, 30.0).friction_psi, -(3.0 + 1.0), 1e-12);
}

TEST(Load, ASecondCurveHoldsThePistonBetweenTheTwo) {
  Parameters p = Full();
  std::array<LoadCurve::Point, 2> lower = {{{0.0, 90.0}, {8.0, 90.0}}};
  std::array<LoadCurve::Point, 2> upper = {{{0.0, 100.0}, {8.0, 100.0}}};
  p.load.opening = LoadCurve(upper);
  p.load.closing = LoadCurve(lower);
  p.load.has_closing = true;
  const Derived d(p);
  State s = SteadyStateAt(d, 4.0).state;
  EXPECT_EQ(s.p3_psi, 100.0);
  for (const auto& [p3_psi, motion] : {std::pair{99.0, Motion::kStuck},
                                       {91.0, Motion::kStuck},
                                       {100.1, Motion::kUp},
                                       {89.9, Motion::kDown}}) {
    s.p3_psi = p3_psi;
    EXPECT_EQ(ModeAtRest(d, s).motion, motion) << p3_psi << " psi";
  }
}

TEST(Load, HeldBeyondItsTable) {
  Parameters p = Full();
  p.load.beyond = LoadBeyond::kHold;
  const Derived d(p);
  EXPECT_EQ(d.load_up.PressureAt(0.0), 67.5);
  EXPECT_EQ(d.load_up.PressureAt(9.0), 103.0);
  EXPECT_NEAR(d.load_up.PressureAt(4.1), 98.2, 1e-12);
}

TEST(Supply, AFullStrokeSagsAFinitePump) {
  Parameters p = Full();
  p.supply.pump_flow_in3_s = 200.0;
  const Derived d(p);
  const SteadyState start = SteadyStateAt(d, 2.0);
  ASSERT_TRUE(start);
  EXPECT_LT(start.state.p2_psi, 300.0) << "at rest the band carries the consumption";
  // 85 in³/s of 200 take 0.42 of the band of 10 psi.
  EXPECT_NEAR((300.0 - start.state.p2_psi) / 10.0, (start.outputs.q3_in3_s + start.outputs.q4_in3_s) / 200.0,
              1e-9);
  double lowest = 300.0;
  State s = start.state;
  for (int i = 0; i < 3'000; ++i) {
    s = Step(d, s, 45.0).state;
    lowest = std::min(lowest, s.p2_psi);
  }
  EXPECT_LT(lowest, 250.0);
  p.supply.pump_flow_in3_s = 50.0;
  EXPECT_EQ(SteadyStateAt(Derived(p), 2.0).error, SteadyStateError::kPumpTooSmall);
}

TEST(Stabilizer, BelowPrechargeTheDiaphragmSitsAndOnlyTheOilGives) {
  Parameters p = Full();
  p.stabilizer.enabled = true;
  const Derived d(p);
  State s = SteadyStateAt(d, 4.0).state;
  s.p8_psi = 10.0;
  s.p3_psi = 11.0;
  s.mode = ModeAtRest(d, s);
  EXPECT_TRUE(s.mode.diaphragm_seated);
  const double seated = Rates(d, s.Vector(), s.mode, 30.0)[kP8];
  s.mode.diaphragm_seated = false;
  const double free = Rates(d, s.Vector(), s.mode, 30.0)[kP8];
  EXPECT_GT(seated / free, 100.0) << "V8/K against V_gas/(k P)";
}

TEST(Stabilizer, AtItsChargePressureItsCapacityIsTheThesisWithAbsolutePressure) {
  Parameters p = Full();
  p.stabilizer.enabled = true;
  const Derived d(p);
  State s = SteadyStateAt(d, 4.0).state;
  s.p3_psi += 1.0;
  const StateVector rate = Rates(d, s.Vector(), s.mode, 30.0);
  const double Q8 = CapillaryFlow(1.0, d.R7, d.b7);
  EXPECT_NEAR(Q8 / rate[kP8], 100.0 / 110'000.0 + 100.0 / (1.4 * (103.0 + kAtmospherePsi)), 1e-6)
      << "errata 18";
}

TEST(FullPhysics, IsTheThesisWhereTheAdditionsDoNotAct) {
  // Small step, p_t far below every pressure difference, no air: x3 agrees to 1e-5 in.
  Parameters full = Full();
  full.orifice.transition_pressure_psi = 1e-3;
  const Derived thesis(testing::Nominal());
  const Derived d(full);
  const SteadyState start = SteadyStateAt(thesis, 4.0);
  const State a = After(thesis, start.state, start.p1_psi + 0.27, 1'000);
  const State b = After(d, SteadyStateAt(d, 4.0).state, start.p1_psi + 0.27, 1'000);
  EXPECT_NEAR(a.x3_in, b.x3_in, 1e-5);
  EXPECT_NEAR(a.p3_psi, b.p3_psi, 0.05);
}

TEST(FullPhysics, OilIsConserved) {
  // Balance of the oil under the piston over a full stroke: d(ln content) = (flow - displacement)/V dt, and
  // the content is a function of P3 alone. Residual against the flow passed: below 1e-6.
  Parameters p = Full();
  p.oil.air_fraction = 0.005;
  const Derived d(p);
  const auto content =
      [&](double p_psi) {  // ln of liquid per volume, by Simpson's rule over the compressibility
        constexpr int kSteps = 20'000;
        const double h = p_psi / kSteps;
        double sum = d.oil.Compressibility(0.0) + d.oil.Compressibility(p_psi);
        for (int i = 1; i < kSteps; ++i) sum += (i % 2 == 1 ? 4.0 : 2.0) * d.oil.Compressibility(i * h);
        return sum * h / 3.0;
      };
  const SteadyState start = SteadyStateAt(d, 2.0);
  State s = start.state;
  const auto volume = [&](const State& at) { return d.V3_at_zero + d.A3 * at.x3_in; };
  const double before = volume(s) * std::exp(content(s.p3_psi));
  double gained = 0.0;
  double passed = 0.0;
  const auto weighted_flow = [&](const State& at) {
    const Outputs o = ComputeOutputs(d, at, 36.0);
    return std::exp(content(at.p3_psi)) * (o.q3_in3_s - o.q6_in3_s - o.q8_in3_s - d.c3 * (at.p3_psi - d.Pe));
  };
  double last = weighted_flow(s);
  constexpr int kParts = 8;  // the balance's own quadrature (trapezium) must not be what is measured
  for (int i = 0; i < 400 * kParts; ++i) {
    s = Step(d, s, 36.0, kTickS / kParts).state;
    const double now = weighted_flow(s);
    gained += 0.5 * (last + now) * kTickS / kParts;
    passed += 0.5 * (std::fabs(last) + std::fabs(now)) * kTickS / kParts;
    last = now;
  }
  const double after = volume(s) * std::exp(content(s.p3_psi));
  EXPECT_GT(passed, 100.0) << "in³: the stroke did happen";
  EXPECT_LT(std::fabs(after - before - gained) / passed, 1e-6);
}

TEST(Step, FollowsTheOilThatStiffensAsItsLastAirDissolves) {
  // The plunger at its stop leaves V4 alone to give way. P4 rises from 50 psi through p_d = 69.8 psi gauge,
  // where the oil becomes a hundred times stiffer, within one tick: planned with the soft oil, P4 was 48,000
  // psi after it.
  Parameters p = Full();
  p.oil.air_fraction = 0.0365;
  p.oil.dissolution_pressure_psi = 84.5;
  p.servo.capillary_diameter_in = 0.349;
  p.servo.main_spring_rate_lbf_in = 98.3;
  p.servo.relay_piston_stroke_in = 14.1;
  p.servo.bulk_modulus_psi = 59'100.0;
  p.supply.pressure_psi = 587.0;
  const Derived d(p);
  State s = {3.1131, -68.6, 0.4833, 49.7055, 0.4833, 587.0, {}};
  s.mode.plunger = Plunger::kAtUpperStop;
  s.mode.relay_port_full = RelayPortOpening(d, s, 283.5) > d.h_relay;
  State fine = s;
  for (int i = 0; i < 32; ++i) fine = Step(d, fine, 283.5, kTickS / 32).state;
  ASSERT_GT(fine.p4_psi, 69.8);
  EXPECT_NEAR(Step(d, s, 283.5).state.p4_psi, fine.p4_psi, 0.005 * d.P2);
}

TEST(FullPhysics, NothingIsEverNonFiniteWhateverTheParametersAndP1) {
  std::mt19937 random(11);  // any seed
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int runs = 0;
  for (int i = 0; i < 150; ++i) {
    Parameters p = Full();
    p.servo.underlap_in = between(-0.005, 0.01);
    p.servo.relay_piston_clearance_in = between(0.0, 0.005);
    p.servo.relay_plunger_clearance_in = between(0.0, 0.005);
    p.servo.bulk_modulus_psi = between(2e4, 4e5);
    p.servo.piston_volume_at_zero_in3 = between(3.0, 100.0);
    p.servo.metering_port_height_in = between(0.02, 1.0);
    p.servo.relay_plunger_travel_in = between(0.02, 1.0);
    p.supply.pressure_psi = between(200.0, 600.0);
    p.oil.air_fraction = i % 3 == 0 ? 0.0 : between(0.0, 0.1);
    p.friction.coulomb_psi = i % 2 == 0 ? 0.0 : between(0.0, 30.0);
    p.friction.breakaway_psi = between(0.0, 40.0);
    p.stabilizer.enabled = i % 4 == 0;
    p.stabilizer.gas_volume_in3 = between(5.0, 200.0);
    p.cam.shape = i % 5 == 0 ? CamShape::kTwoSlope : CamShape::kSingle;
    const Derived d(p);
    const SteadyState start = SteadyStateAt(d, between(0.0, 8.0));
    if (!start) continue;
    ++runs;
    State s = start.state;
    double p1_psi = 0.0;
    for (int tick = 0; tick < 1'500; ++tick) {
      if (tick % 300 == 0) p1_psi = tick % 600 == 0 ? between(0.0, 300.0) : between(15.0, 45.0);
      s = Step(d, s, p1_psi).state;
      ASSERT_TRUE(IsInDomain(d, s)) << "run " << i << ", tick " << tick << ", x3 " << s.x3_in << ", P3 "
                                    << s.p3_psi;
      ASSERT_GE(s.x3_in, 0.0);
      ASSERT_LE(s.x3_in, 8.0);
      ASSERT_GT(s.p3_psi, d.oil.LowestPsi() - 0.05) << "below vapour pressure";
    }
  }
  EXPECT_GE(runs, 80);
}

}  // namespace
}  // namespace servohil::model
