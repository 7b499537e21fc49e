#pragma once
/// One integration step: RK4 in as many sub-steps as the fastest mode asks for, with Coulomb friction as an
/// event, not as a discontinuity inside a stage.
///
/// Between events the motion (stuck, up, down) is fixed, so that the equations are smooth and RK4 keeps its
/// order. A step that ends beyond an event is cut there: the event's place is the root of the cubic Hermite
/// interpolant of v3 (reversal) or of the drive force (breakaway), as accurate as the step itself. At v3 = 0
/// the piston sticks while |drive| <= breakaway, else it slides with the drive. At rest x3 does not change at
/// all.

#include "servohil/model/derived.hpp"
#include "servohil/model/state.hpp"

namespace servohil::model {

inline constexpr double kTickS = 1.0e-4;  ///< integration step [s]: 0.1 ms, the thesis' DELT (Appendix H)

/// Sub-steps of one step: enough that each is at most 1/FastestRate() long, a third of RK4's stability limit,
/// so that a rate that triples within a step is still stable. Found with the relay port thrown open by a P1
/// step of -5 psi (rate 5e4 1/s): one step of 0.1 ms was wrong by 3e-3 in, two by 1e-5 in
/// (tests/data/reference).
inline constexpr int kMaxSubSteps = 16;

/// Events handled in one sub-step. A reversal at 0.1 ms needs an acceleration change no servomotor has, let
/// alone four; past it the piston is held for what is left of the sub-step, and the next one begins at rest.
inline constexpr int kMaxEventsPerSubStep = 4;

struct StepResult {
  State state;
  int sub_steps = 1;
  bool resolved = true;  ///< false: more than kMaxSubSteps would have been needed, the state is less accurate
};

/// State after h seconds at constant P1. Deterministic, real-time safe.
StepResult Step(const Derived& d, const State& state, double p1_psi, double h_s = kTickS) noexcept;

/// The motion of a piston at rest in `state`: stuck, or the direction in which it breaks away.
Motion MotionFromRest(const Derived& d, const State& state) noexcept;

}  // namespace servohil::model
