#include "servohil/model/servomotor.hpp"

#include <cmath>
#include <limits>

#include "servohil/model/laws.hpp"

namespace servohil::model {
namespace {

/// The algebraic part, X(1) to X(7) of Appendix E and Q8.
struct Algebraic {
  double x1, x2, x4, alpha;
  double Q3, Q4, Q5, Q6, Q8;
};

inline Algebraic Solve(const Derived& d, const StateVector& y, double P1) noexcept {
  const double P3 = y[kP3];
  const double P4 = y[kP4];
  Algebraic a;              // NOLINT(cppcoreguidelines-pro-type-member-init): every member is set below
  a.x1 = P1 * d.A1 / d.k1;  // (2.1)
  a.x4 = d.cam.At(y[kX3]);  // (2.15)
  a.alpha = d.cam.SlopeAt(y[kX3]);
  const double x2_minus_x4 = (P4 * d.A2 - d.Fs) / d.k2;  // (2.2)
  a.x2 = x2_minus_x4 + a.x4;
  a.Q3 = OrificeFlow(d.P2 - P3, d.U + x2_minus_x4, d.cr2, d.k_metering);  // (2.5)
  a.Q6 = OrificeFlow(P3, d.U - x2_minus_x4, d.cr2, d.k_metering);         // (2.6)
  a.Q5 = OrificeFlow(P4, a.x2 - a.x1, d.cr1, d.k_relay);                  // (2.4)
  a.Q4 = CapillaryFlow(d.P2 - P4, d.capillary_a, d.capillary_b);          // (2.3)
  a.Q8 = d.G7 * (P3 - y[kP8]);                                            // (5.2)
  return a;
}

}  // namespace

StateVector Rates(const Derived& d, const StateVector& y, Motion motion, double p1_psi) noexcept {
  const Algebraic a = Solve(d, y, p1_psi);
  const double x3 = y[kX3];
  const double v3 = y[kV3];
  const double P3 = y[kP3];
  StateVector rate;
  if (motion == Motion::kStuck) {
    rate[kX3] = 0.0;
    rate[kV3] = 0.0;
  } else {
    const double F_friction = motion == Motion::kUp     ? d.F_coulomb
                              : motion == Motion::kDown ? -d.F_coulomb
                                                        : 0.0;
    rate[kX3] = v3;
    rate[kV3] = (d.A3 * (P3 - d.load.PressureAt(x3)) - d.C * v3 - F_friction) / d.M;
  }
  rate[kP3] = d.beta * (a.Q3 - a.Q6 - a.Q8 - d.A3 * v3 - d.c3 * P3) / (d.V3_at_zero + d.A3 * x3);
  rate[kP4] = (a.Q4 - a.Q5 - d.A2 * a.alpha * v3) / d.relay_compliance;
  // Q8/(V8/beta + Va/(k P8)), written so that one division is enough. Without a stabilizer P8 is P3.
  rate[kP8] = d.stabilizer ? a.Q8 * y[kP8] / (d.V8_over_beta * y[kP8] + d.Va_over_k) : rate[kP3];
  return rate;
}

Outputs ComputeOutputs(const Derived& d, const State& state, double p1_psi) noexcept {
  const Algebraic a = Solve(d, state.Vector(), p1_psi);
  double friction_lbf = 0.0;
  switch (state.motion) {
    case Motion::kFree:
      break;
    case Motion::kStuck:
      friction_lbf = DriveForce(d, state);
      break;
    case Motion::kUp:
      friction_lbf = d.F_coulomb;
      break;
    case Motion::kDown:
      friction_lbf = -d.F_coulomb;
      break;
  }
  return {a.x1, a.x2, a.x4, a.Q3, a.Q4, a.Q5, a.Q6, a.Q8, friction_lbf / d.A3};
}

double FastestRate(const Derived& d, const State& s, double p1_psi) noexcept {
  const Algebraic a = Solve(d, s.Vector(), p1_psi);
  const double V3 = d.V3_at_zero + d.A3 * s.x3_in;
  const double port = a.x2 - a.x1;
  const double sqrt_P4 = std::sqrt(std::fabs(s.p4_psi));
  const auto orifice_slope = [](double Q, double dP) noexcept {
    return dP == 0.0 ? std::numeric_limits<double>::infinity() : std::fabs(Q / (2.0 * dP));
  };
  // d/dx sqrt(x² + c²) is at most 1, and 0 where the port is closed.
  const double dQ5 = orifice_slope(a.Q5, s.p4_psi) + (port > 0.0 ? d.k_relay * sqrt_P4 * d.A2 / d.k2 : 0.0);
  const double relay = (dQ5 + 1.0 / d.capillary_a) / d.relay_compliance;
  const double dQ3_dQ6 = orifice_slope(a.Q3, d.P2 - s.p3_psi) + orifice_slope(a.Q6, s.p3_psi);
  const double stabilizer = d.stabilizer ? d.G7 * s.p8_psi / (d.V8_over_beta * s.p8_psi + d.Va_over_k) : 0.0;
  const double oil_spring = std::sqrt(d.beta * d.A3 * d.A3 / (V3 * d.M));
  const double piston = d.beta / V3 * (dQ3_dQ6 + d.c3 + d.G7) + stabilizer + oil_spring;
  return relay > piston ? relay : piston;
}

double DriveForce(const Derived& d, const State& state) noexcept {
  return d.A3 * (state.p3_psi - d.load.PressureAt(state.x3_in));
}

bool IsInDomain(const Derived& d, const State& state) noexcept {
  return state.Vector().allFinite() && d.V3_at_zero + d.A3 * state.x3_in > 0.0 &&
         (!d.stabilizer || state.p8_psi > 0.0);
}

}  // namespace servohil::model
