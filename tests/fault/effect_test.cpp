// What each fault of the model does to the servomotor, with a number that follows from the model's laws. A
// fault of the catalogue that has no test of its effect fails.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>

#include "bench.hpp"
#include "effect_tests.hpp"
#include "linear/linearization.hpp"
#include "model/laws.hpp"
#include "model/reconcile.hpp"

namespace servohil::fault {
namespace {

using model::Derived;
using model::Parameters;
using std::numbers::pi;
using testing::Bench;
using testing::Full;
using testing::Under;
using testing::WithStabilizer;

void ExpectRelative(double value, double expected, double tolerance, const char* what = "") {
  EXPECT_NEAR(value / expected, 1.0, tolerance) << what << ": " << value << ", expected " << expected;
}

// ---- oil

/// Frequency [Hz] at which the piston rings on its oil after a push of the load, from zeros of v3: the closed
/// metering ports leave the oil spring and the mass.
double RingingHz(Bench& bench) {
  bench.Inject("load_step", {2.0});
  std::vector<double> zeros;
  for (int i = 0; i < 1'000 && zeros.size() < 4; ++i) {
    const double before = bench.State().v3_in_s;
    const double after = bench.Run(1).state.v3_in_s;
    if (before != 0.0 && (before < 0.0) != (after < 0.0)) zeros.push_back(i + before / (before - after));
  }
  if (zeros.size() < 4) return 0.0;
  return 1.0 / ((zeros[3] - zeros[1]) * model::kTickS);
}
/// Closed ports: no flow but the oil's compression.
Parameters WithPortsShut() {
  Parameters p = testing::Full();
  p.servo.underlap_in = -0.01;
  p.servo.relay_plunger_clearance_in = 1e-4;
  return p;
}

/// w = sqrt(K A3²/(V3 M)): air lowers K = K_l to (1 + V_g)/(1/K_l + V_g/P_abs), V_g = (r + 1e-6) (p_atm -
/// p_v)/(P_abs - p_v). At 103 psi 2 % of air leave 33,200 of 110,000 psi: 0.549 of the frequency.
void AirEntrainment() {
  const auto modulus = [](double r) {
    const double gap = 103.0 + 14.696 - 0.05;
    const double gas = (r + 1e-6) * 14.646 / gap;
    return (1.0 + gas) / (1.0 / 110e3 + gas / gap);
  };
  EXPECT_NEAR(std::sqrt(modulus(0.02) / modulus(0.0)), 0.549, 1e-3);
  Bench without(WithPortsShut());
  Bench with(WithPortsShut());
  with.Inject("air_entrainment", {0.02});
  ExpectRelative(RingingHz(with) / RingingHz(without), std::sqrt(modulus(0.02) / modulus(0.0)), 0.02);
}

/// w = sqrt(K A3²/(V3 M)), V3 = 30 + 4 A3: 173 Hz at 110,000 psi.
void BulkModulus() {
  const double A3 = pi / 4 * 9.99 * 9.99;
  const double nominal_hz = std::sqrt(110e3 * A3 * A3 / ((30.0 + 4.0 * A3) * 1.6686)) / (2 * pi);
  Bench without(WithPortsShut());
  ExpectRelative(RingingHz(without), nominal_hz, 0.02);
  Bench with(WithPortsShut());
  with.Inject("bulk_modulus", {40e3});
  ExpectRelative(RingingHz(with), nominal_hz * std::sqrt(40.0 / 110.0), 0.02);
}

/// Q4 with the kinematic viscosity of MIL-H-5606 by Walther's law through 13.2 cSt at 40 °C and 4.9 cSt at
/// 100 °C, and its density 866 (1 - 7e-4 (T - 15)): both relative to 40 °C, where the custom oil has 2.2e-6
/// and 8e-5.
void Temperature(const char* fault, double t_c) {
  const auto w = [](double nu) { return std::log10(std::log10(nu + 0.7)); };
  const double slope = (w(4.9) - w(13.2)) / (std::log10(373.15) - std::log10(313.15));
  const double at_t = w(13.2) + slope * (std::log10(t_c + 273.15) - std::log10(313.15));
  const double nu = std::pow(10, std::pow(10, at_t)) - 0.7;
  const double thin = (1 - 7e-4 * (t_c - 15)) / (1 - 7e-4 * (40 - 15));
  const double mu = 2.2e-6 * nu / 13.2 * thin;
  EXPECT_EQ(mu > 2.2e-6, t_c < 40.0);
  Bench bench;
  bench.Inject(fault, {t_c}).Run(1);
  const double a = 128 * mu * 4.0 / (pi * std::pow(0.1875, 4));
  const double b = 2.28 * 8e-5 * thin / (16 * pi * mu * 4.0);
  ExpectRelative(bench.Outputs().q4_in3_s, model::CapillaryFlow(300.0 - bench.State().p4_psi, a, b), 1e-9);
}
void ColdOil() {
  Temperature("cold_oil", 10.0);
}
void HotOil() {
  Temperature("hot_oil", 80.0);
}

// ---- supply

/// k sqrt(x² + c²) of a metering port, without the laminar transition: 0.01 % at 5 psi, less above.
double Metering(double x, double dP) {
  return 0.625 * pi * 3.495 * std::sqrt(2 / 8e-5) * std::sqrt(std::max(x, 0.0) * std::max(x, 0.0) + 4e-6) *
         std::sqrt(dP);
}
constexpr double kA3 = pi / 4 * 9.99 * 9.99;

/// With the relay port fully open the plunger is held up by P4 = Pe and x2 - x4 = (A2 P4 - Fs)/k2,
/// and closes at v = Q6(U - (x2 - x4), P3 - Pe)/A3. 3 psi take it from -0.062 to -0.028 in, and more than
/// half of the speed.
void DrainBackPressure() {
  double v_in_s[2] = {};
  for (int faulted = 0; faulted < 2; ++faulted) {
    const double Pe = 3.0 * faulted;
    Bench bench;
    if (faulted != 0) bench.Inject("drain_back_pressure", {Pe});
    bench.p1_psi = 0.0;
    v_in_s[faulted] = bench.Run(200).state.v3_in_s;
    const double opening = (2.341 * bench.State().p4_psi - 13.5) / 212;
    const double port_flow = bench.Outputs().q4_in3_s - 2.341 * 0.32 * v_in_s[faulted];
    const double drop_psi = bench.State().p4_psi - Pe;
    const double conductance = model::OrificeConductance(drop_psi, 0.25 * 0.25 + 4e-6, 543.3, 0.1);
    ExpectRelative(drop_psi * conductance, port_flow, 0.01, "P4 is what the open port leaves");
    const double flow = Metering(0.002 - opening, bench.State().p3_psi - Pe) -
                        Metering(0.002 + opening, 300 - bench.State().p3_psi);
    ExpectRelative(v_in_s[faulted], -flow / kA3, 0.03, "the piston accelerates a little");
  }
  EXPECT_LT(v_in_s[1] / v_in_s[0], 0.5);
  // Above Fs/A2 = 5.77 psi the plunger does not close any more, whatever P1.
  Bench lost;
  lost.Inject("drain_back_pressure", {6.0});
  lost.p1_psi = 0.0;
  EXPECT_EQ(lost.Run(60'000).state.x3_in, 8.0);
}

/// Opening at its fastest, ports open to their 0.25 in: v = Q3(0.25, P2 - P3)/A3, so in proportion to sqrt(P2
/// - P3).
void SupplySag() {
  double v_in_s[2] = {};
  double p3_psi[2] = {};
  for (int faulted = 0; faulted < 2; ++faulted) {
    Bench bench(testing::Full(), 5.5);
    if (faulted != 0) bench.Inject("supply_sag", {60.0});
    bench.p1_psi = 300.0;
    while (bench.State().x3_in < 6.2) bench.Run(1);  // the load is 67 psi from 5.5 to 6.25 in
    v_in_s[faulted] = bench.State().v3_in_s;
    p3_psi[faulted] = bench.State().p3_psi;
    EXPECT_EQ(bench.State().p2_psi, faulted != 0 ? 240.0 : 300.0);
  }
  ExpectRelative(v_in_s[1] / v_in_s[0], std::sqrt((240.0 - p3_psi[1]) / (300.0 - p3_psi[0])), 0.03);
  EXPECT_LT(v_in_s[1], 0.9 * v_in_s[0]);
}

/// P2 = 300 + 10 sin(2 pi 25 t), t from the fault's first tick on: 400 ticks are a period.
void SupplyRipple() {
  Bench bench;
  bench.Inject("supply_ripple", {10.0, 25.0});
  for (int tick = 0; tick < 800; ++tick)
    ASSERT_NEAR(bench.Run(1).state.p2_psi, 300.0 + 10.0 * std::sin(2 * pi * tick / 400.0), 1e-9) << tick;
  // A finite pump's set point: C2 dP2/dt = (Q_max/band) (P_set - P2) and what is drawn, C2 = V/(k P_abs), so
  // that P2 follows with g/sqrt(g² + w²), g = 200/10/C2 = 17.6 1/s: 0.111 of it at 25 Hz.
  Parameters p = testing::Full();
  p.supply.pump_flow_in3_s = 200.0;
  Bench finite(p);
  finite.Inject("supply_ripple", {2.0, 25.0}).Run(4'000);
  double low = finite.State().p2_psi;
  double high = low;
  for (int tick = 0; tick < 400; ++tick) {
    finite.Run(1);
    low = std::min(low, finite.State().p2_psi);
    high = std::max(high, finite.State().p2_psi);
  }
  const double g = 20.0 / (500.0 / (1.4 * 314.696));
  ExpectRelative((high - low) / 2, 2.0 * g / std::hypot(g, 2 * pi * 25.0), 0.03);
}

/// P2 is 0 at once; with Q3 gone the plunger falls to -Fs/k2 = -0.0637 in and the piston closes, down to its
/// stop. With a finite pump P2 falls by (Q3 + Q4)/C2, C2 = V/(k P_abs) at the set point.
void SupplyLoss() {
  Bench bench;
  bench.Inject("supply_loss").Run(600);
  EXPECT_EQ(bench.State().p2_psi, 0.0);
  const double opening = (2.341 * bench.State().p4_psi - 13.5) / 212;
  const double P3 = bench.State().p3_psi;
  ExpectRelative(bench.State().v3_in_s,
                 -(Metering(0.002 - opening, P3) + Metering(0.002 + opening, P3)) / kA3, 0.03);
  EXPECT_EQ(bench.Run(20'000).state.x3_in, 0.0);

  Parameters p = testing::Full();
  p.supply.pump_flow_in3_s = 200.0;
  Bench finite(p);
  const double P2 = finite.State().p2_psi;
  const double consumption = finite.Outputs().q3_in3_s + finite.Outputs().q4_in3_s;
  finite.Inject("supply_loss").Run(10);
  ExpectRelative(P2 - finite.State().p2_psi, consumption * 10e-4 / (500.0 / (1.4 * 314.696)), 0.01);
}

// ---- valve and relay

/// A jammed piston and a P1 that shuts the relay port leave dP4/dt = (Q4 - Q5)/(V4/K + A2²/k2): the time from
/// P4 at rest to the plunger's stop, (Fs + 0.25 k2)/A2 = 28.4 psi, is an integral over P4.
double TimeToOpenS(double diameter_in, double from_psi) {
  const double a = 128 * 2.2e-6 * 4.0 / (pi * std::pow(diameter_in, 4));
  const double b = 2.28 * 8e-5 / (16 * pi * 2.2e-6 * 4.0);
  const double stop_psi = (13.5 + 0.25 * 212) / 2.341;
  const double capacity = 11.6 / 110e3 + 2.341 * 2.341 / 212;
  double time_s = 0.0;
  constexpr int kParts = 10'000;
  for (int i = 0; i < kParts; ++i) {
    const double P4 = from_psi + (stop_psi - from_psi) * (i + 0.5) / kParts;
    const double Q5 =
        0.625 * pi * 1.75 * std::sqrt(2 / 8e-5) * 0.002 * std::sqrt(P4);  // the closed port's clearance
    time_s += capacity / (model::CapillaryFlow(300 - P4, a, b) - Q5) * (stop_psi - from_psi) / kParts;
  }
  return time_s;
}
void CapillaryPlugged() {
  for (double lost : {0.0, 0.5}) {
    Bench bench;
    const double expected_s = TimeToOpenS(0.1875 * std::sqrt(1 - lost), bench.State().p4_psi);
    bench.Inject("piston_jammed").Inject("capillary_plugged", {lost});
    bench.p1_psi = 300.0;
    int ticks = 0;
    while (bench.State().mode.plunger == model::Plunger::kFree && ticks < 10'000) bench.Run(1), ++ticks;
    EXPECT_NEAR(ticks, expected_s / model::kTickS, 1.5) << "area lost " << lost;
  }
  const double nominal_s = TimeToOpenS(0.1875, 5.707);
  EXPECT_GT(TimeToOpenS(0.1875 * std::sqrt(0.5), 5.707) / nominal_s, 1.9) << "about as long again";
}

/// At rest the port passes Q4: with half the width it is open by sqrt((2 e)² - c²) instead of sqrt(e² - c²),
/// e = Q4/(k sqrt(P4)), and the same P1 leaves the piston higher by the difference over alpha.
void RelayPortSilted() {
  Bench bench;
  const model::Outputs before = bench.Outputs();
  const double e =
      before.q4_in3_s / (0.625 * pi * 1.75 * std::sqrt(2 / 8e-5) * std::sqrt(bench.State().p4_psi));
  EXPECT_NEAR(before.x2_in - before.x1_in, std::sqrt(e * e - 4e-6), 1e-5);
  bench.Inject("relay_port_silted", {0.5}).Settle();
  const model::Outputs after = bench.Outputs();
  EXPECT_NEAR(after.x2_in - after.x1_in, std::sqrt(4 * e * e - 4e-6), 1e-4);
  EXPECT_NEAR(bench.State().x3_in - 4.0, (std::sqrt(4 * e * e - 4e-6) - std::sqrt(e * e - 4e-6)) / 0.32,
              2e-3);
}

/// Underlap and clearance both twice as large: the same balance at openings twice as large, twice the flow at
/// rest.
void PlungerWorn() {
  Bench bench;
  const double before = bench.Outputs().q3_in3_s;
  bench.Inject("plunger_worn", {0.002, 0.002}).Settle();
  ExpectRelative(bench.Outputs().q3_in3_s, 2.0 * before, 0.01);
}

/// U = -0.002 in: both ports are shut over a dead band. At rest the drain's opens until it passes what comes
/// through the supply's clearance, (y² + c²) P3 = c² (P2 - P3): x2 - x4 = U - y.
void PlungerOverlapped() {
  Bench bench;
  bench.Inject("plunger_overlapped", {0.004}).Settle();
  const double P3 = bench.State().p3_psi;
  EXPECT_NEAR(bench.Opening(), -0.002 - 0.002 * std::sqrt((300 - P3) / P3 - 1), 1e-5);
}

/// x1 = A1 P1/k1.
void PilotSpringWeak() {
  Bench bench;
  const double before_in = bench.Outputs().x1_in;
  bench.Inject("pilot_spring_weak", {0.05}).Settle();
  ExpectRelative(bench.Outputs().x1_in, before_in / 0.95, 1e-12);
  EXPECT_NEAR(bench.State().x3_in - 4.0, before_in * (1 / 0.95 - 1) / 0.32, 0.01) << "the bushing follows x1";
}

/// Relay port fully open: x2 - x4 = (A2 P4 - Fs)/k2 goes down 1.25 times as far, and the piston as much
/// faster.
void MainSpringWeak() {
  double v_in_s[2] = {};
  for (int faulted = 0; faulted < 2; ++faulted) {
    Bench bench;
    if (faulted != 0) bench.Inject("main_spring_weak", {0.2});
    bench.p1_psi = 0.0;
    v_in_s[faulted] = bench.Run(200).state.v3_in_s;
    EXPECT_NEAR(bench.Opening(), (2.341 * bench.State().p4_psi - 13.5) / (faulted != 0 ? 0.8 * 212 : 212),
                1e-9);
  }
  ExpectRelative(v_in_s[1] / v_in_s[0], (0.002 + 0.0616 / 0.8) / (0.002 + 0.0616), 0.02);
}

/// A1 P1/(0.01 k1) is far beyond the relay piston's stop at 8 in, and x4 = 0.32 x3 + 2.9 < 8: no feedback is
/// enough.
void PilotSpringBroken() {
  Bench bench;
  bench.Inject("pilot_spring_broken").Run(20'000);
  EXPECT_EQ(bench.Outputs().x1_in, 8.0);
  EXPECT_EQ(bench.State().x3_in, 8.0);
  EXPECT_EQ(bench.State().mode.motion, model::Motion::kAtUpperStop);
}

/// The wide open relay port leaves P4 = 0.17 psi and more: A2 P4 lifts the plunger by (A2 P4 - 0.135)/2.12 =
/// 0.13 in.
void MainSpringBroken() {
  Bench bench;
  bench.Inject("main_spring_broken");
  bench.p1_psi = 0.0;
  bench.Run(50);
  EXPECT_NEAR(bench.Opening(), (2.341 * bench.State().p4_psi - 0.135) / 2.12, 1e-9);
  EXPECT_GT(bench.Opening(), 0.1);
  EXPECT_EQ(bench.Run(20'000).state.x3_in, 8.0) << "whatever P1";
}

/// v = (Q3 - Q6)/A3 of the ports where they are stuck.
void PlungerStuck() {
  for (double p1_psi : {0.0, 300.0}) {
    Bench bench(testing::Full(), 5.5);
    bench.p1_psi = p1_psi;
    bench.Inject("plunger_stuck", {0.005}).Run(1'000);
    EXPECT_NEAR(bench.Opening(), 0.005, 1e-6);
    const double P3 = bench.State().p3_psi;
    ExpectRelative(bench.State().v3_in_s, (Metering(0.007, 300 - P3) - Metering(-0.003, P3)) / kA3, 0.01);
    EXPECT_EQ(bench.Run(40'000).state.x3_in, 8.0);
  }
}

/// Its x1 is that of P1 = x1 k1/A1 for ever, and so is the position that belongs to it.
void RelayPistonStuck() {
  const double A1 = pi / 4 * (2.494 * 2.494 - 0.996 * 0.996);
  Bench at_this_pressure;
  at_this_pressure.p1_psi = 4.2 * 30.0 / A1;
  at_this_pressure.Settle();
  EXPECT_GT(std::fabs(at_this_pressure.State().x3_in - 4.0), 0.05);
  for (double p1_psi : {0.0, 300.0}) {
    Bench bench;
    bench.p1_psi = p1_psi;
    bench.Inject("relay_piston_stuck", {4.2}).Settle();
    EXPECT_EQ(bench.Outputs().x1_in, 4.2);
    EXPECT_NEAR(bench.State().x3_in, at_this_pressure.State().x3_in, 1e-6);
  }
}

/// x4 = alpha x3 + x3* + offset: alpha x3 makes room for it.
void CamSlipped() {
  Bench bench;
  bench.Inject("cam_slipped", {0.1}).Settle();
  EXPECT_NEAR(bench.State().x3_in - 4.0, -0.1 / 0.32, 5e-3);
}

/// The same x4 at the same P1: alpha x3 stays, x3 = 4/0.8.
void CamWorn() {
  Bench bench;
  bench.Inject("cam_worn", {0.2}).Settle();
  EXPECT_NEAR(bench.State().x3_in, 4.0 / 0.8, 0.01);
}

// ---- piston and load

/// At rest it holds what is below breakaway to the last bit, and gives way to what is above.
void Holds(const char* fault, double psi) {
  for (double load_psi : {-psi - 1, -psi + 1, psi - 1, psi + 1}) {
    Bench bench;
    bench.Inject(fault, {psi}).Inject("load_step", {load_psi}).Run(50);
    const bool holds = std::fabs(load_psi) < psi;
    EXPECT_EQ(bench.State().x3_in == 4.0, holds) << load_psi;
    EXPECT_TRUE(!holds || bench.State().mode.motion == model::Motion::kStuck) << load_psi;
  }
}
void CoulombFriction() {
  Holds("coulomb_friction", 10.0);
}
/// And the faster it slides the less is left of it: B_s/(1 + (v/v_s)²), v_s = 0.1 in/s.
void Stiction() {
  Holds("stiction", 20.0);
  Bench bench;
  bench.Inject("stiction", {20.0}).Inject("load_step", {30.0}).Run(20);
  const double v = bench.State().v3_in_s;
  ASSERT_LT(v, -0.1);
  EXPECT_NEAR(bench.Outputs().friction_psi, -20.0 / (1 + 100 * v * v), 1e-9);
}

void PistonJammed() {
  Bench bench;
  bench.Inject("piston_jammed");
  for (double p1_psi : {300.0, 0.0}) {
    bench.p1_psi = p1_psi;
    const double P3 = bench.State().p3_psi;
    for (int i = 0; i < 3'000; ++i) ASSERT_EQ(bench.Run(1).state.x3_in, 4.0);
    EXPECT_GT(std::fabs(bench.State().p3_psi - P3), 90.0) << "the oil's pressure moves all the same";
  }
}

/// c3 P3 = pi d3 (c/2)³/(12 mu L3) P3 must come through the ports: 11³ = 1331 times 0.019 in³/s.
void PistonLeak() {
  Bench bench;
  bench.Inject("piston_leak", {0.01}).Settle();
  const double c3 = pi * 9.99 * std::pow(0.0055, 3) / (12 * 2.2e-6 * 0.8);
  ExpectRelative(bench.Outputs().q3_in3_s - bench.Outputs().q6_in3_s, c3 * bench.State().p3_psi, 1e-4);
  EXPECT_GT(c3 * bench.State().p3_psi, 20.0);
}

/// At rest P3 carries the load.
void LoadStep() {
  Bench bench;
  bench.Inject("load_step", {20.0}).Settle();
  EXPECT_NEAR(bench.State().p3_psi, model::testing::ThesisLoad().PressureAt(bench.State().x3_in) + 20.0,
              1e-3);
}

/// Slowly enough for the mass, P3 - p_L(x3) is the load's oscillation: 1 Hz against the oil spring's 173 Hz.
void LoadOscillation() {
  Bench bench;
  bench.Inject("load_oscillation", {10.0, 1.0}).Run(10'000);
  for (int tick = 10'000; tick < 20'000; ++tick) {
    const model::State& s = bench.Run(1).state;
    const double extra_psi = s.p3_psi - model::testing::ThesisLoad().PressureAt(s.x3_in);
    ASSERT_NEAR(extra_psi, 10.0 * std::sin(2 * pi * tick / 10'000.0), 0.1) << tick;
  }
}

/// From 3.4 to 5 in the load stays 131 psi; at 4 in it was 103.
void StemStuck() {
  Bench bench;
  bench.Inject("stem_stuck", {3.4, 1.6}).Settle();
  EXPECT_NEAR(bench.State().p3_psi, 131.0, 1e-3);
}

// ---- stabilizer

double R7(double diameter_in) {
  return 128 * 2.2e-6 * 15.0 / (pi * std::pow(diameter_in, 4));
}
const double kB7 = 2.28 * 8e-5 / (16 * pi * 2.2e-6 * 15.0);

/// P8 stays, and the piston goes as without a stabilizer.
void StabilizerIsolated() {
  Bench isolated(testing::WithStabilizer());
  Bench without(testing::Full());
  isolated.Inject("stabilizer_isolated");
  const double P8 = isolated.State().p8_psi;
  for (Bench* bench : {&isolated, &without}) bench->p1_psi += 1.0;
  for (int i = 0; i < 2'000; ++i)
    ASSERT_NEAR(isolated.Run(1).state.x3_in, without.Run(1).state.x3_in, 1e-6) << "tick " << i;
  EXPECT_GT(std::fabs(isolated.State().p3_psi - P8), 1.0);
  EXPECT_NEAR(isolated.State().p8_psi, P8, 1e-6);
}

/// P3 - P8 = R7 Q8 (1 + b7 Q8): half the area has four times the resistance.
void StabilizerCapillaryPlugged() {
  Bench bench(testing::WithStabilizer());
  bench.Inject("stabilizer_capillary_plugged", {0.5}).Inject("load_step", {20.0}).Run(30);
  const double dP = bench.State().p3_psi - bench.State().p8_psi;
  ASSERT_GT(std::fabs(dP), 1.0);
  ExpectRelative(bench.Outputs().q8_in3_s, model::CapillaryFlow(dP, 4 * R7(0.30), kB7), 1e-9);
}

/// dP8/dt = Q8/C8, C8 = V8/K + V_gas/(k P8_abs), V_gas = left V_a at the charge pressure of 103 psi, which is
/// P8 here.
void Gas(const char* fault, const std::vector<double>& values, double left) {
  Bench bench(testing::WithStabilizer());
  bench.Inject(fault, values).Inject("load_step", {20.0}).Run(5);
  const double before_psi = bench.State().p8_psi;
  const double flow = bench.Outputs().q8_in3_s;
  bench.Run(1);
  const double mean_flow = 0.5 * (flow + bench.Outputs().q8_in3_s);
  const double C8 = 100.0 / 110e3 + left * 100.0 / (1.4 * 117.696);
  ASSERT_NEAR(before_psi, 103.0, 2.0);
  ExpectRelative((bench.State().p8_psi - before_psi) / model::kTickS, mean_flow / C8, 0.03);
}
void GasChargeLost() {
  Gas("gas_charge_lost", {0.5}, 0.5);
  // The diaphragm seats where what is left of the gas fills the shell: P V^k, half of it at 0.5^1.4 of 34.7
  // psi abs.
  EXPECT_NEAR(testing::Under(testing::WithStabilizer(), "gas_charge_lost", {0.5}).stabilizer.precharge_psi,
              34.696 * std::pow(0.5, 1.4) - 14.696, 1e-9);
}
void DiaphragmRuptured() {
  Gas("diaphragm_ruptured", {}, 0.001);
}

}  // namespace

const testing::Effects testing::kModelEffects = {
    {"air_entrainment", AirEntrainment},
    {"bulk_modulus", BulkModulus},
    {"cold_oil", ColdOil},
    {"hot_oil", HotOil},
    {"drain_back_pressure", DrainBackPressure},
    {"supply_sag", SupplySag},
    {"supply_ripple", SupplyRipple},
    {"supply_loss", SupplyLoss},
    {"capillary_plugged", CapillaryPlugged},
    {"relay_port_silted", RelayPortSilted},
    {"plunger_worn", PlungerWorn},
    {"plunger_overlapped", PlungerOverlapped},
    {"pilot_spring_weak", PilotSpringWeak},
    {"main_spring_weak", MainSpringWeak},
    {"pilot_spring_broken", PilotSpringBroken},
    {"main_spring_broken", MainSpringBroken},
    {"plunger_stuck", PlungerStuck},
    {"relay_piston_stuck", RelayPistonStuck},
    {"cam_slipped", CamSlipped},
    {"cam_worn", CamWorn},
    {"coulomb_friction", CoulombFriction},
    {"stiction", Stiction},
    {"piston_jammed", PistonJammed},
    {"piston_leak", PistonLeak},
    {"load_step", LoadStep},
    {"load_oscillation", LoadOscillation},
    {"stem_stuck", StemStuck},
    {"stabilizer_isolated", StabilizerIsolated},
    {"stabilizer_capillary_plugged", StabilizerCapillaryPlugged},
    {"gas_charge_lost", GasChargeLost},
    {"diaphragm_ruptured", DiaphragmRuptured},
};

namespace {

/// Of all three kinds; null: no test.
void (*EffectOf(const std::string& fault))() {
  for (const testing::Effects* effects :
       {&testing::kModelEffects, &testing::kSensorEffects, &testing::kBusEffects}) {
    if (const auto found = effects->find(fault); found != effects->end()) return found->second;
  }
  return nullptr;
}

class EveryFault : public ::testing::TestWithParam<Spec> {};
class EveryModelFault : public ::testing::TestWithParam<Spec> {};

std::vector<Spec> ModelFaults() {
  std::vector<Spec> faults;
  for (const Spec& spec : Catalogue()) {
    if (spec.ActsAs<ParameterAct>()) faults.push_back(spec);
  }
  return faults;
}

TEST_P(EveryFault, HasItsEffect) {
  const auto effect = EffectOf(GetParam().name);
  ASSERT_NE(effect, nullptr) << "no test of its effect: it has no place in the catalogue";
  effect();
}

/// Cleared, the run goes on as one that has no faults and the same state.
TEST_P(EveryModelFault, IsGoneWhenCleared) {
  Bench bench(testing::WithStabilizer());
  bench.Inject(GetParam().name, {}, 20);
  bench.p1_psi += 3.0;
  bench.Run(300);
  const simulation::Sample faulted = bench.simulation.Now();
  const Derived derived(bench.parameters);
  Bench unfaulted(testing::WithStabilizer());
  simulation::Sample sample = faulted;
  sample.state = model::Reconciled(derived, faulted.state, bench.p1_psi);
  unfaulted.simulation.Restore(sample, {});
  unfaulted.p1_psi = bench.p1_psi;
  ASSERT_EQ(bench.simulation.Faults().Clear(GetParam().id), 1U);
  for (int i = 0; i < 1'000; ++i)
    ASSERT_EQ(bench.Run(1).state_hash, unfaulted.Run(1).state_hash) << "tick " << i << " after the fault";
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryFault, ::testing::ValuesIn(Catalogue().begin(), Catalogue().end()),
                         [](const auto& fault) { return std::string(fault.param.name); });

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryModelFault, ::testing::ValuesIn(ModelFaults()),
                         [](const auto& fault) { return std::string(fault.param.name); });

TEST(Effects, AreAllOfTheCatalogue) {
  EXPECT_EQ(testing::kModelEffects.size() + testing::kSensorEffects.size() + testing::kBusEffects.size(),
            Catalogue().size());
}

/// The thesis' point, chapter V: the stabilizer damps; shut, plugged or without gas it damps less.
TEST(Effects, AFaultOfTheStabilizerTakesDampingAway) {
  Parameters p = testing::WithStabilizer();
  p.oil.air_fraction = 0.02;
  const auto damping = [](const Parameters& q) {
    const Derived d(q);
    return linear::Poles(linear::Linearize(d, model::SteadyStateAt(d, 4.0)).system).LeastDamped().Damping();
  };
  const double healthy = damping(p);
  Parameters without = p;
  without.stabilizer.enabled = false;
  EXPECT_GT(healthy, damping(without));
  EXPECT_NEAR(damping(testing::Under(p, "stabilizer_isolated")), damping(without), 1e-6);
  EXPECT_LT(damping(testing::Under(p, "diaphragm_ruptured")), healthy);
}

}  // namespace
}  // namespace servohil::fault
