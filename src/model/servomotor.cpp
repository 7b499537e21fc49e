#include "model/servomotor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/laws.hpp"

namespace servohil::model {
namespace {

/// The algebraic part: X(1) to X(7) of Appendix E, Q8, and the stiffnesses that go with them.
struct Algebraic {
  double x1, x2, x4, alpha;
  double Q3, Q4, Q5, Q6, Q8;
  double G3, G5, G6;  ///< full: conductances of the orifices [in⁵/(lbf s)]
  double Stiff3;      ///< of the oil under the piston: K/V3 [psi/in³]
  double Stiff4;      ///< above the plunger: 1/(V4/K + A2²/k2) [psi/in³]
  double Stiff8;      ///< of the stabilizer: 1/C8 [psi/in³]
};

inline double PlungerAgainstBushing(const Derived& d, double P4, Plunger plunger) noexcept {
  switch (plunger) {
    case Plunger::kAtLowerStop:
      return -d.plunger_travel;
    case Plunger::kAtUpperStop:
      return d.plunger_travel;
    default:
      return P4 * d.plunger_per_psi + d.plunger_at_zero;  // (2.2)
  }
}

inline double RelayPistonPosition(const Derived& d, double P1) noexcept {
  const double x1 = P1 * d.x1_per_psi;  // (2.1)
  return x1 <= d.x1_low ? d.x1_low : x1 >= d.x1_stop ? d.x1_stop : x1;
}

/// 1/(V s + C) for a compressibility s [1/psi].
inline double InverseCompliance(double V, const OilModulus::Fraction& s, double C) noexcept {
  return s.denominator / (V * s.numerator + C * s.denominator);
}

/// C8 = V8/K + V_gas/(k P8), V_gas = V_a (P_charge/P8)^(1/k), absolute; V8/K with the diaphragm on its seat.
inline double InverseCapacity(const Derived& d, double P8, bool seated) noexcept {
  if (!d.full) return 1.0 / (d.V8 / d.beta + d.Va / (d.k_gas * P8));  // (5.7)
  const double P8_abs = std::max(P8 + kAtmospherePsi, 1e-3);          // a stage may look there, no state is
  const double gas = seated ? 0.0 : d.gas_capacity * d.gas_power(P8_abs);
  return InverseCompliance(d.V8, d.oil.CompressibilityFraction(P8), gas);
}

inline Algebraic Solve(const Derived& d, const StateVector& y, const Mode& mode, double P1) noexcept {
  const double P3 = y[kP3];
  const double P4 = y[kP4];
  const double P2 = y[kP2];
  const double V3 = d.V3_at_zero + d.A3 * y[kX3];
  Algebraic a;  // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
  a.x1 = RelayPistonPosition(d, P1);
  a.x4 = d.cam.At(y[kX3]);  // (2.15)
  a.alpha = d.cam.SlopeAt(y[kX3]);
  const double x2_minus_x4 = PlungerAgainstBushing(d, P4, mode.plunger);
  a.x2 = x2_minus_x4 + a.x4;
  if (d.full) {
    const double p_t = d.p_transition;
    const double open3 = OpeningSquared(d.U + x2_minus_x4, d.cr2, d.h_metering);
    const double open6 = OpeningSquared(d.U - x2_minus_x4, d.cr2, d.h_metering);
    const double open5 = OpeningSquared(a.x2 - a.x1, d.cr1, d.h_relay);
    a.G3 = OrificeConductance(P2 - P3, open3, d.k_metering, p_t);
    a.G6 = OrificeConductance(P3 - d.Pe, open6, d.k_metering, p_t);
    a.G5 = OrificeConductance(P4 - d.Pe, open5, d.k_relay, p_t);
    a.Q3 = a.G3 * (P2 - P3);
    a.Q6 = a.G6 * (P3 - d.Pe);
    a.Q5 = a.G5 * (P4 - d.Pe);
    const double spring = mode.plunger == Plunger::kFree ? d.spring_compliance : 0.0;
    a.Stiff3 = InverseCompliance(V3, d.oil.CompressibilityFraction(P3), 0.0);
    a.Stiff4 = InverseCompliance(d.V4, d.oil.CompressibilityFraction(P4), spring);
  } else {
    a.Q3 = OrificeFlow(P2 - P3, d.U + x2_minus_x4, d.cr2, d.k_metering);  // (2.5)
    a.Q6 = OrificeFlow(P3, d.U - x2_minus_x4, d.cr2, d.k_metering);       // (2.6)
    a.Q5 = OrificeFlow(P4, a.x2 - a.x1, d.cr1, d.k_relay);                // (2.4)
    a.Stiff3 = d.beta / V3;
    a.Stiff4 = 1.0 / (d.V4 / d.beta + d.spring_compliance);
  }
  a.Q4 = CapillaryFlow(P2 - P4, d.capillary_a, d.capillary_b);  // (2.3)
  if (d.stabilizer) {
    a.Q8 = CapillaryFlow(P3 - y[kP8], d.R7, d.b7);  // (5.2)
    a.Stiff8 = InverseCapacity(d, y[kP8], mode.diaphragm_seated);
  } else {
    a.Q8 = 0.0;
    a.Stiff8 = 1.0;
  }
  return a;
}

/// Load and friction on a moving piston [lbf], both against upward motion.
inline double Resistance(const Derived& d, double x3, double v3, Motion motion) noexcept {
  if (motion == Motion::kFree) return d.A3 * d.load_up.PressureAt(x3) + d.C_viscous * v3;
  const double slip = v3 * d.inverse_stribeck;
  const double dry = d.full ? d.F_coulomb + (d.F_breakaway - d.F_coulomb) / (1.0 + slip * slip) : d.F_coulomb;
  return motion == Motion::kUp ? d.A3 * d.load_up.PressureAt(x3) + dry + d.C_viscous * v3
                               : d.A3 * d.load_down.PressureAt(x3) - d.closing_ratio * dry + d.C_viscous * v3;
}

inline double PumpFlow(const Derived& d, double P2) noexcept {
  return d.pump_flow * std::clamp((d.P2 - P2) * d.inverse_band, 0.0, 1.0);
}

inline StateVector RatesOf(const Derived& d, const Algebraic& a, const StateVector& y,
                           const Mode& mode) noexcept {
  const double x3 = y[kX3];
  const double v3 = y[kV3];
  const double P3 = y[kP3];
  StateVector rate;
  if (mode.PistonRests()) {
    rate[kX3] = 0.0;
    rate[kV3] = 0.0;
  } else {
    rate[kX3] = v3;
    rate[kV3] = (d.A3 * P3 - Resistance(d, x3, v3, mode.motion) - d.C * v3) / d.M;
  }
  rate[kP3] = (a.Q3 - a.Q6 - a.Q8 - d.A3 * v3 - d.c3 * (P3 - d.Pe)) * a.Stiff3;
  rate[kP4] = (a.Q4 - a.Q5 - d.A2 * a.alpha * v3) * a.Stiff4;
  rate[kP8] = d.stabilizer ? a.Q8 * a.Stiff8 : rate[kP3];
  rate[kP2] = d.pump_flow > 0.0 ? (PumpFlow(d, y[kP2]) - a.Q3 - a.Q4) / d.C2 : 0.0;
  return rate;
}

TimeScales ScalesOf(const Derived& d, const Algebraic& a, const State& s, const StateVector& rates) noexcept {
  const auto slope = [&](double G, double Q, double dP) noexcept {
    if (d.full) return G;
    return dP == 0.0 ? std::numeric_limits<double>::infinity() : std::fabs(Q / (2.0 * dP));
  };
  // dQ5/dx2: 0 where the port is closed or fully open.
  const double x = a.x2 - a.x1;
  const double dQ5_dx2 = x > 0.0 && x < d.h_relay ? std::fabs(a.Q5) * x / (x * x + d.cr1 * d.cr1) : 0.0;
  const double relay =
      (slope(a.G5, a.Q5, s.p4_psi - d.Pe) + dQ5_dx2 * d.plunger_per_psi + 1.0 / d.capillary_a) * a.Stiff4;
  const double G7 = d.stabilizer ? 1.0 / d.R7 : 0.0;
  const double oil_spring = std::sqrt(d.A3 * d.A3 * a.Stiff3 / d.M);
  const double piston =
      a.Stiff3 * (slope(a.G3, a.Q3, s.p2_psi - s.p3_psi) + slope(a.G6, a.Q6, s.p3_psi - d.Pe) + d.c3 + G7) +
      G7 * a.Stiff8 + oil_spring;
  double stiffness = 0.0;
  double ports = 0.0;
  if (d.full) {
    constexpr double kCornerIn = 0.002;
    ports = s.mode.plunger == Plunger::kFree ? std::fabs(rates[kP4]) * d.plunger_per_psi / kCornerIn : 0.0;
    stiffness = std::fmax(std::fabs(rates[kP3] * d.oil.StiffnessChange(s.p3_psi)),
                          std::fabs(rates[kP4] * d.oil.StiffnessChange(s.p4_psi)));
  }
  return {relay, piston, stiffness, ports};
}
}  // namespace

StateVector Rates(const Derived& d, const StateVector& y, const Mode& mode, double p1_psi) noexcept {
  return RatesOf(d, Solve(d, y, mode, p1_psi), y, mode);
}

RatesAndScales RatesAndScalesAt(const Derived& d, const State& s, double p1_psi) noexcept {
  const StateVector y = s.Vector();
  const Algebraic a = Solve(d, y, s.mode, p1_psi);
  const StateVector rates = RatesOf(d, a, y, s.mode);
  return {rates, ScalesOf(d, a, s, rates)};
}

Outputs ComputeOutputs(const Derived& d, const State& state, double p1_psi) noexcept {
  const Algebraic a = Solve(d, state.Vector(), state.mode, p1_psi);
  double friction_lbf = 0.0;
  switch (state.mode.motion) {
    case Motion::kStuck:
      friction_lbf = DriveUp(d, state);
      break;
    case Motion::kFree:
    case Motion::kUp:
      friction_lbf = Resistance(d, state.x3_in, state.v3_in_s, state.mode.motion) -
                     d.A3 * d.load_up.PressureAt(state.x3_in);
      break;
    case Motion::kDown:
      friction_lbf = Resistance(d, state.x3_in, state.v3_in_s, state.mode.motion) -
                     d.A3 * d.load_down.PressureAt(state.x3_in);
      break;
    case Motion::kAtLowerStop:
    case Motion::kAtUpperStop:
      break;
  }
  return {a.x1, a.x2, a.x4, a.Q3, a.Q4, a.Q5, a.Q6, a.Q8, friction_lbf / d.A3};
}

double RelayPortOpening(const Derived& d, const State& s, double p1_psi) noexcept {
  return PlungerAgainstBushing(d, s.p4_psi, s.mode.plunger) + d.cam.At(s.x3_in) -
         RelayPistonPosition(d, p1_psi);
}

double DriveUp(const Derived& d, const State& state) noexcept {
  return d.A3 * (state.p3_psi - d.load_up.PressureAt(state.x3_in));
}

double DriveDown(const Derived& d, const State& state) noexcept {
  return d.A3 * (state.p3_psi - d.load_down.PressureAt(state.x3_in));
}

bool IsInDomain(const Derived& d, const State& state) noexcept {
  const double lowest_gas_psi = d.full ? -kAtmospherePsi : 0.0;
  return state.Vector().allFinite() && d.V3_at_zero + d.A3 * state.x3_in > 0.0 &&
         (!d.stabilizer || state.p8_psi > lowest_gas_psi);
}

}  // namespace servohil::model
