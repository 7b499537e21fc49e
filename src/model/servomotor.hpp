#pragma once
/// The servomotor's equations of motion: thesis chapter II as implemented in Appendix E, with the transient
/// flow stabilizer of chapter V as in Appendix H ("thesis"), and what MODEL.md adds to them ("full").

#include "model/derived.hpp"
#include "model/state.hpp"

namespace servohil::model {

/// What follows from the state and the control pressure without integration.
struct Outputs {
  double x1_in = 0.0;         ///< relay piston, (2.1)
  double x2_in = 0.0;         ///< relay plunger, (2.2)
  double x4_in = 0.0;         ///< relay bushing, (2.15)
  double q3_in3_s = 0.0;      ///< supply to piston chamber, (2.5)
  double q4_in3_s = 0.0;      ///< through the capillary, (2.3)
  double q5_in3_s = 0.0;      ///< relay chamber to drain, (2.4)
  double q6_in3_s = 0.0;      ///< piston chamber to drain, (2.6)
  double q8_in3_s = 0.0;      ///< into the stabilizer, (5.2)
  double friction_psi = 0.0;  ///< friction against upward motion, as a pressure; stuck: what holds the piston
};

/// dy/dt for constant P1 [psi] in a given mode. While the piston rests, x3 and v3 stay. Real-time safe.
///   M dv3/dt = A3 P3 - C v3 - A3 p_L(x3) - F_friction                           (4.1), (4.4)
///   dP3/dt   = K (Q3 - Q6 - Q8 - A3 v3 - c3 (P3 - Pe)) / (V3_0 + A3 x3)         (5.12)
///   dP4/dt   = (Q4 - Q5 - A2 alpha v3) / (V4/K + A2²/k2)                        (4.3) with (2.2), (2.15)
///   dP8/dt   = Q8 / C8                                     (5.13); without a stabilizer P8 is P3
///   dP2/dt   = (Q_pump - Q3 - Q4) / C2                     0 where the supply is constant
StateVector Rates(const Derived& d, const StateVector& y, const Mode& mode, double p1_psi) noexcept;

/// Real-time safe.
Outputs ComputeOutputs(const Derived& d, const State& state, double p1_psi) noexcept;

/// How fast the state can change [1/s]: what the integrator's sub-steps follow.
struct TimeScales {
  /// Upper bounds of the fastest mode, by chamber. Thesis: unbounded as any orifice's dP tends to 0.
  ///   relay   (dQ5/dP4 + dQ5/dx2 A2/k2 + 1/a) / (V4/K + A2²/k2)
  ///   piston  K/V3 (dQ3/dP3 + dQ6/dP3 + c3 + 1/R7) + 1/(R7 C8) + sqrt(K A3² / (V3 M))
  /// where the root is the frequency of oil spring and piston (section 3.4).
  double relay_mode;
  double piston_mode;
  /// |dP/dt| over the pressure in which the oil's stiffness changes, of P3 and P4: where a cavity opens or
  /// closes, or the last air dissolves. 0 in the thesis.
  double stiffness;
  /// |d(x2 - x4)/dt| over 0.002 in, the width of the corner that underlap and clearance give the metering
  /// ports. 0 in the thesis.
  double ports;

  double FastestMode() const noexcept { return relay_mode > piston_mode ? relay_mode : piston_mode; }
};

struct RatesAndScales {
  StateVector rates;
  TimeScales scales;
};

/// Both, for the price of one evaluation and a few divisions. Real-time safe.
RatesAndScales RatesAndScalesAt(const Derived& d, const State& state, double p1_psi) noexcept;

/// x2 - x1 [in]: opening of orifice 5, before its clearance and height. Real-time safe.
double RelayPortOpening(const Derived& d, const State& state, double p1_psi) noexcept;

/// Net force on a piston at rest, friction aside, that would move it up or down [lbf]: A3 (P3 - p_L(x3)),
/// each with the load of its direction. Real-time safe.
double DriveUp(const Derived& d, const State& state) noexcept;
double DriveDown(const Derived& d, const State& state) noexcept;

/// The state is finite and inside the domain of the equations: V3 > 0, the stabilizer's gas pressure above 0
/// (thesis: gauge, full: absolute). Real-time safe.
bool IsInDomain(const Derived& d, const State& state) noexcept;

}  // namespace servohil::model
