/// Properties that hold for any parameters: symmetry, continuity, energy, conservation of oil.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/laws.hpp"
#include "model/servomotor.hpp"
#include "model/steady_state.hpp"
#include "model/step.hpp"
#include "nominal.hpp"

namespace servohil::model {
namespace {

/// Uniform in [low, high].
double Between(double low, double high) {
  constexpr int kParts = 1'000'000;
  return low + (high - low) * *rc::gen::inRange(0, kParts + 1) / kParts;
}

/// A positive value within a factor of another, uniform in its logarithm.
double Around(double value, double factor) {
  return value * std::pow(factor, Between(-1.0, 1.0));
}

LoadCurve ConstantLoad(double p_psi) {
  const std::array<LoadCurve::Point, 2> points = {{{0.0, p_psi}, {8.0, p_psi}}};
  return LoadCurve(points);
}

RC_GTEST_PROP(Symmetry, EveryFlowIsOddInItsPressureDifference, ()) {
  const double dP = Between(0.0, 1000.0);
  const double x = Between(-0.3, 0.3);
  const double c = Between(0.0, 0.02);
  const double k = Around(1000.0, 10.0);
  const double p_t = Around(0.1, 100.0);
  RC_ASSERT(OrificeFlow(-dP, x, c, k) == -OrificeFlow(dP, x, c, k));
  const double a_squared = OpeningSquared(x, c, 0.25);
  RC_ASSERT(OrificeConductance(-dP, a_squared, k, p_t) == OrificeConductance(dP, a_squared, k, p_t));
  const double a = Around(0.3, 100.0);
  const double b = Between(0.0, 1.0);
  RC_ASSERT(CapillaryFlow(-dP, a, b) == -CapillaryFlow(dP, a, b));
}

/// What is left of a function's change over [a, b] after halving the interval so often, always toward the
/// half that changes more: next to nothing where it is continuous, the jump where it is not.
template <typename Function>
double Jump(const Function& f, double a, double b, int halvings) {
  double fa = f(a);
  double fb = f(b);
  for (int i = 0; i < halvings; ++i) {
    const double m = 0.5 * (a + b);
    const double fm = f(m);
    if (std::fabs(fm - fa) > std::fabs(fb - fm)) {
      b = m;
      fb = fm;
    } else {
      a = m;
      fa = fm;
    }
  }
  return std::fabs(fb - fa);
}

TEST(Jump, FindsAJumpAndNothingElse) {
  EXPECT_EQ(Jump([](double x) { return x < 0.3 ? 0.0 : 1.0; }, -1.0, 2.0, 45), 1.0);
  EXPECT_LT(Jump([](double x) { return std::cbrt(x - 0.3); }, -1.0, 2.0, 45), 1e-4);
}

RC_GTEST_PROP(Continuity, TheSourcesOrificeHasNoJumpOverOpeningAndPressure, ()) {
  const double c = Between(0.0, 0.02);
  const double x = Between(-0.1, 0.3);
  // Its slope is infinite at dP = 0: k a sqrt(2000 psi 3e-14) is left, of flows up to k a sqrt(1000 psi).
  RC_ASSERT(Jump([&](double dP) { return OrificeFlow(dP, x, c, 1.0); }, -1000.0, 999.0, 45) < 3e-6);
  RC_ASSERT(Jump([&](double open) { return OrificeFlow(100.0, open, c, 1.0); }, -0.1, 0.3, 45) < 1e-12);
}

/// Any parameters, a state of them between the stops, and a control pressure.
struct Drawn {
  Parameters p;
  State s;
  double p1_psi;
};

Drawn Draw() {
  Drawn drawn{testing::Nominal(), {}, Between(0.0, 300.0)};
  Parameters& p = drawn.p;
  p.physics = Physics::kFull;
  p.oil.air_fraction = Between(0.0, 0.05);
  p.oil.air_polytropic_index = Between(1.0, 1.4);
  p.oil.dissolution_pressure_psi = *rc::gen::arbitrary<bool>() ? Between(20.0, 400.0) : 0.0;
  p.servo.bulk_modulus_psi = Around(1e5, 3.0);
  p.servo.underlap_in = Between(-0.01, 0.01);
  p.servo.relay_plunger_clearance_in = Between(0.0, 0.005);
  p.friction.coulomb_psi = Between(0.0, 20.0);
  p.friction.breakaway_psi = Between(0.0, 30.0);
  p.friction.viscous_psi_s_in = Between(0.0, 2.0);
  p.stabilizer.enabled = true;
  p.stabilizer.polytropic_index = Between(1.0, 2.0);
  p.supply.pump_flow_in3_s = Between(0.0, 300.0);
  p.cam.shape = *rc::gen::arbitrary<bool>() ? CamShape::kTwoSlope : CamShape::kSingle;
  drawn.s = {Between(0.1, 7.9),
             Between(0.0, 60.0),
             Between(-14.0, 300.0),
             Between(-14.0, 300.0),
             Between(0.0, 300.0),
             Between(200.0, 310.0),
             {}};
  drawn.s.mode.motion = *rc::gen::element(Motion::kFree, Motion::kUp, Motion::kStuck);
  return drawn;
}

RC_GTEST_PROP(Continuity, NoRateJumpsOverAnyStateOrP1ButAtTheKneeOfTheCam, ()) {
  // All laws together: each enters a rate. Ranges of the state, one after the other: x3, v3, P3, P4, P8, P2,
  // P1.
  constexpr double kLow[] = {0.0, 0.0, -14.0, -14.0, -14.0, 200.0, 0.0};
  constexpr double kHigh[] = {8.0, 60.0, 310.0, 310.0, 310.0, 320.0, 300.0};
  const Drawn drawn = Draw();
  const Derived d(drawn.p);
  // dP4/dt has the cam's slope in it, which jumps at the knee by what is stated here.
  const double jump_of_alpha = d.cam.SlopeAt(0.0) - d.cam.SlopeAt(8.0);
  const double relay_compliance = d.V4 * d.oil.Compressibility(drawn.s.p4_psi) + d.spring_compliance;
  const double knee = d.A2 * jump_of_alpha * drawn.s.v3_in_s / relay_compliance;
  for (std::size_t over = 0; over < 7; ++over) {
    for (int of = 0; of < 6; ++of) {
      double largest = 1000.0;  // in/s², psi/s: rates of interest are larger
      const auto rate = [&](double value) {
        StateVector y = drawn.s.Vector();
        if (over < 6) y[static_cast<Eigen::Index>(over)] = value;
        const double result = Rates(d, y, drawn.s.mode, over == 6 ? value : drawn.p1_psi)[of];
        largest = std::max(largest, std::fabs(result));
        return result;
      };
      const double stated = of == kP4 && over == kX3 ? knee * (1.0 + 1e-9) : 0.0;
      const double before = Jump(rate, kLow[over], kHigh[over], 30);
      const double after = Jump(rate, kLow[over], kHigh[over], 42);
      // 12 halvings leave 1/4096 of a slope, all of a jump; 1e-9 is rounding, where flows of 900 in³/s
      // cancel.
      RC_ASSERT(after <= stated + 0.01 * before + 1e-9 * largest);
    }
  }
}

/// A piston of mass M on the oil under it, nothing flowing: ports overlapped, no leakage, no viscous damping.
Derived OilSpring(const Parameters& p) {
  Derived d(p);
  d.U = -1.0;
  d.cr2 = 0.0;
  d.c3 = 0.0;
  d.C = 0.0;
  return d;
}

/// Kinetic energy, and that of oil and constant load against rest at P3 = load [lbf in]:
///   M v3²/2 + ∫ (P - load) V/K dP from the load to P3,   V(P) = V3 exp(∫dP'/K from P to P3)
double Energy(const Derived& d, const State& s, double load_psi) {
  constexpr int kSteps = 64;  // of RK4 in P: relative error (dP/64 K)⁴, far below 1e-9
  const double h = (load_psi - s.p3_psi) / kSteps;
  const double V3 = d.V3_at_zero + d.A3 * s.x3_in;
  using Pair = Eigen::Vector2d;  // ln V/V3, energy
  const auto slope = [&](double P, const Pair& y) {
    const double S = d.oil.Compressibility(P);
    return Pair(-S, -(P - load_psi) * V3 * std::exp(y[0]) * S);
  };
  Pair y = Pair::Zero();
  for (int i = 0; i < kSteps; ++i) {
    const double P = s.p3_psi + i * h;
    const Pair k1 = slope(P, y);
    const Pair k2 = slope(P + 0.5 * h, y + 0.5 * h * k1);
    const Pair k3 = slope(P + 0.5 * h, y + 0.5 * h * k2);
    const Pair k4 = slope(P + h, y + h * k3);
    y += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
  }
  return 0.5 * d.M * s.v3_in_s * s.v3_in_s + y[1];
}

struct Swing {
  Parameters p;
  State s;
  double load_psi = 200.0;
};

/// Swings of up to about 150 psi about the load: P3 stays above atmospheric, where Energy() holds.
bool NoCavityOpens(const Swing& swing, const Derived& d, double energy) {
  const double V3 = d.V3_at_zero + d.A3 * swing.s.x3_in;
  return std::sqrt(2.0 * energy * swing.p.servo.bulk_modulus_psi / V3) < 150.0;
}

Swing DrawSwing() {
  Swing swing{testing::Nominal(), {}};
  swing.p.physics = Physics::kFull;
  swing.p.load.opening = ConstantLoad(swing.load_psi);
  swing.p.oil.air_fraction = *rc::gen::arbitrary<bool>() ? Between(0.0, 0.02) : 0.0;
  swing.p.servo.bulk_modulus_psi = Around(1e5, 2.0);
  swing.p.servo.load_mass_lbf_s2_in = Around(1.3656, 2.0);
  swing.s = {
      Between(0.05, 7.95), Between(-3.0, 3.0), swing.load_psi + Between(-50.0, 50.0), 5.7, 0.0, 300.0, {}};
  return swing;
}

RC_GTEST_PROP(Energy, OilSpringAndMassExchangeItAndCreateNone, ()) {
  Swing swing = DrawSwing();
  swing.s.x3_in = Between(0.5, 7.5);  // no stop is reached
  const Derived d = OilSpring(swing.p);
  State s = swing.s;
  const double begin = Energy(d, s, swing.load_psi);
  RC_PRE(begin > 1e-3 && NoCavityOpens(swing, d, begin));
  for (int i = 0; i < 1000; ++i) {
    s = Step(d, s, 30.0).state;
    // A sub-step of 0.5 rad may be wrong by 0.5⁵/120 = 2.6e-4 of the amplitude, either way; of all these
    // errors less than one is left: none of them adds up.
    if (i % 10 == 0) RC_ASSERT(Energy(d, s, swing.load_psi) <= begin * (1.0 + 1e-4));
  }
  // RK4 at up to 0.5 rad a sub-step takes (0.5)⁶/144 of it in each: what is lost is the method's, and little.
  RC_ASSERT(Energy(d, s, swing.load_psi) >= 0.5 * begin);
}

RC_GTEST_PROP(Energy, IsNotCreatedByImpactsOnAStop, ()) {
  Swing swing = DrawSwing();
  const bool lower = *rc::gen::arbitrary<bool>();
  swing.s.x3_in = lower ? Between(0.0, 0.002) : Between(7.998, 8.0);
  swing.s.v3_in_s = lower ? Between(-2.0, -1.0) : Between(1.0, 2.0);
  const Derived d = OilSpring(swing.p);
  State s = swing.s;
  const double begin = Energy(d, s, swing.load_psi);
  RC_PRE(NoCavityOpens(swing, d, begin));
  for (int i = 0; i < 1000; ++i) {
    s = Step(d, s, 30.0).state;
    // The place of an impact is the root of a cubic through a sub-step of 0.5 rad; the piston is put onto the
    // stop from there: a few thousandths of the oil spring's energy at most. Each impact takes the piston's
    // own.
    if (i % 10 == 0) RC_ASSERT(Energy(d, s, swing.load_psi) <= begin * (1.0 + 5e-3));
  }
}

RC_GTEST_PROP(Energy, FallsByWhatFrictionTakesUntilThePistonRests, ()) {
  Swing swing = DrawSwing();
  swing.p.friction.coulomb_psi = Between(2.0, 20.0);
  swing.p.friction.breakaway_psi = Between(0.0, 30.0);
  swing.p.friction.closing_ratio = Between(0.5, 2.0);
  const Derived d = OilSpring(swing.p);
  State s = swing.s;
  s.mode.motion = s.v3_in_s >= 0.0 ? Motion::kUp : Motion::kDown;
  const double begin = Energy(d, s, swing.load_psi);
  RC_PRE(NoCavityOpens(swing, d, begin));
  double last = begin;
  for (int i = 0; i < 1500; ++i) {
    s = Step(d, s, 30.0).state;
    if (i % 5 != 0) continue;
    const double now = Energy(d, s, swing.load_psi);
    RC_ASSERT(now <= last + 1e-6 * begin);
    last = now;
  }
  RC_ASSERT(s.mode.PistonRests());
}

TEST(FullPhysics, OilIsConservedThroughACavityThatOpensAndCloses) {
  // A trip in the middle of a fast opening: the piston still rises while the oil under it runs to the drain.
  Parameters p = testing::Nominal();
  p.physics = Physics::kFull;
  const Derived d(p);
  const double c = 1e-6 * (kAtmospherePsi - p.oil.vapour_pressure_psi);
  // exp ∫dP/K in closed form, V_g = c/gap:  exp((P - c ln(gap + c))/K_l) / (1 + c/gap)
  const auto content = [&](double P) {
    const double gap = P - d.oil.LowestPsi();
    return std::exp((P - c * std::log(gap + c)) / p.servo.bulk_modulus_psi) / (1.0 + c / gap);
  };
  const auto gain = [&](const State& s, double p1_psi) {
    const Outputs o = ComputeOutputs(d, s, p1_psi);
    return content(s.p3_psi) * (o.q3_in3_s - o.q6_in3_s - d.c3 * (s.p3_psi - d.Pe));
  };
  const auto oil = [&](const State& s) { return content(s.p3_psi) * (d.V3_at_zero + d.A3 * s.x3_in); };
  State s = SteadyStateAt(d, 2.0).state;
  const double before = oil(s);
  double gained = 0.0;
  double passed = 0.0;
  double lowest_psi = 0.0;
  constexpr int kParts = 64;  // the balance's own quadrature must not be what is measured
  for (int i = 0; i < 900 * kParts; ++i) {
    const double p1_psi = i < 300 * kParts ? 300.0 : i < 600 * kParts ? 0.0 : 60.0;
    const double first = gain(s, p1_psi);
    s = Step(d, s, p1_psi, kTickS / kParts).state;
    const double both = 0.5 * (first + gain(s, p1_psi)) * kTickS / kParts;
    gained += both;
    passed += std::fabs(both);
    lowest_psi = std::min(lowest_psi, s.p3_psi);
  }
  EXPECT_LT(lowest_psi, -14.0) << "a cavity did open";
  EXPECT_GT(s.p3_psi, 0.0) << "and close";
  EXPECT_LT(std::fabs(oil(s) - before - gained) / passed, 1e-6);
}

}  // namespace
}  // namespace servohil::model
