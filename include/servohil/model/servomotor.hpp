#pragma once
/// The servomotor's equations of motion: thesis chapter II as implemented in Appendix E, with the transient
/// flow stabilizer of chapter V as in Appendix H.

#include "servohil/model/derived.hpp"
#include "servohil/model/state.hpp"

namespace servohil::model {

/// What follows from the state and the control pressure without integration.
struct Outputs {
  double x1_in = 0.0;     ///< relay piston, (2.1)
  double x2_in = 0.0;     ///< relay plunger, (2.2)
  double x4_in = 0.0;     ///< relay bushing, (2.15)
  double q3_in3_s = 0.0;  ///< supply to piston chamber, (2.5)
  double q4_in3_s = 0.0;  ///< through the capillary, (2.3)
  double q5_in3_s = 0.0;  ///< relay chamber to drain, (2.4)
  double q6_in3_s = 0.0;  ///< piston chamber to drain, (2.6)
  double q8_in3_s = 0.0;  ///< into the stabilizer, (5.2)
  double friction_psi =
      0.0;  ///< Coulomb friction against upward motion, as a pressure; at rest what holds the piston
};

/// dy/dt for constant P1 [psi] and a given kind of motion. While stuck, x3 and v3 stay. Real-time safe.
///   M dv3/dt = A3 P3 - C v3 - A3 p_L(x3) - F_friction                           (4.1), (4.4)
///   dP3/dt   = beta (Q3 - Q6 - Q8 - A3 v3 - c3 P3) / (V3_0 + A3 x3)             (5.12)
///   dP4/dt   = (Q4 - Q5 - A2 alpha v3) / (V4/beta + A2²/k2)                     (4.3) with (2.2), (2.15)
///   dP8/dt   = Q8 / (V8/beta + V_a/(k P8))                                      (5.13); without a stabilizer
///   P8 is P3
StateVector Rates(const Derived& d, const StateVector& y, Motion motion, double p1_psi) noexcept;

/// Real-time safe.
Outputs ComputeOutputs(const Derived& d, const State& state, double p1_psi) noexcept;

/// Upper bound on how fast the state can change by itself [1/s]: the largest of
///   the relay chamber's   (dQ5/dP4 + dQ5/dx2 A2/k2 + 1/a) / (V4/beta + A2²/k2)
///   the piston chamber's  beta/V3 (dQ3/dP3 + dQ6/dP3 + c3 + G7) + G7/C8 + sqrt(beta A3² / (V3 M))
/// where an orifice has dQ/dP = Q/(2 dP), C8 is the stabilizer's capacity (5.8), and the root is the
/// frequency of oil spring and piston (section 3.4). Unbounded as any dP tends to 0. Real-time safe.
double FastestRate(const Derived& d, const State& state, double p1_psi) noexcept;

/// Force that friction has to hold for the piston to stay at rest [lbf]: A3 (P3 - p_L(x3)). Real-time safe.
double DriveForce(const Derived& d, const State& state) noexcept;

/// The state is finite and inside the domain of the equations: V3 > 0 and, with the stabilizer, P8 > 0 (its
/// gas law divides by it). Real-time safe.
bool IsInDomain(const Derived& d, const State& state) noexcept;

}  // namespace servohil::model
