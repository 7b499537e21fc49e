#pragma once
/// One integration step, in as many sub-steps as the fastest mode asks for, with friction, stops and contacts
/// as events, not as discontinuities inside a stage.
///
/// Between events the mode is fixed, so that the equations are smooth and the integrator keeps its order. A
/// sub-step that ends beyond an event is cut there: the event's place is the root of the cubic Hermite
/// interpolant of the quantity that changes sign (velocity, drive force, position, pressure). At v3 = 0 the
/// piston sticks while its drive is within breakaway, else it slides with the drive; at a stop it rests while
/// its drive presses it there. At rest x3 does not change at all.

#include "model/derived.hpp"
#include "model/state.hpp"

namespace servohil::model {

inline constexpr double kTickS = 1.0e-4;  ///< integration step [s]: 0.1 ms, the thesis' DELT (Appendix H)

/// Sub-steps of one step at most, and one more for each event. No tick of the 93 scenarios of tests/data asks
/// for more; what does over the envelope, a closing cavity first of all, is judged by its error
/// (envelope_sweep.hpp).
inline constexpr int kMaxSubSteps = 48;

/// RK4's sub-steps times the rate of the fastest mode: a sixth of its stability limit. Found with the relay
/// port thrown open by a P1 step of -5 psi (5e4 1/s), where one step of 0.1 ms is wrong by 3e-3 in
/// (tests/data/reference), and with slow arrivals at a stop, which 1e-6 in delay by ticks
/// (tests/data/envelope).
inline constexpr double kRateTimesSubStep = 0.5;

/// Physics "full": where RK4 would need more sub-steps than this, kRosenbrockSubSteps of the L-stable
/// Rosenbrock method do as well, whatever the rate.
inline constexpr double kMaxRungeKuttaSubSteps = 24.0;
inline constexpr double kRosenbrockSubSteps = 8.0;

/// A sub-step lets P3 and P4 change by no more than this share of the pressure in which the oil's stiffness
/// does: of their distance to vapour pressure, or to the pressure at which the last air dissolves.
inline constexpr double kStiffnessShare = 0.5;

/// Events handled in one step: of each of piston, plunger, diaphragm and relay port two. Each ends a
/// sub-step, since the mode that follows may be far faster. After the last the piston is held for what is
/// left of the step, and the next one begins at rest.
inline constexpr int kMaxEvents = 8;

struct StepResult {
  State state;
  int sub_steps = 0;     ///< at most kMaxSubSteps + kMaxEvents
  bool resolved = true;  ///< false: more than kMaxSubSteps would have been needed, the state is less accurate
};

/// State after h seconds at constant P1. Deterministic, real-time safe.
StepResult Step(const Derived& d, const State& state, double p1_psi, double h_s = kTickS) noexcept;

/// The mode of a state at rest between the stops: stuck, free or about to move, as its pressures are.
Mode ModeAtRest(const Derived& d, const State& state) noexcept;

}  // namespace servohil::model
