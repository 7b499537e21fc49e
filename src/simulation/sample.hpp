#pragma once
/// What the simulation has come to.

#include <cstdint>

#include "model/state.hpp"

namespace servohil::simulation {

/// Where the simulation is after `tick` ticks.
struct Sample {
  std::uint64_t tick = 0;  ///< t = tick * model::kTickS
  double p1_psi = 0.0;     ///< control pressure during the tick that ended here
  model::State state;
  std::uint64_t unresolved_ticks = 0;  ///< ticks that needed more sub-steps than model::kMaxSubSteps, so far
  int sub_steps = 0;                   ///< of this tick; 0 at rest
  bool model_fault = false;            ///< latched: the model left its domain, the state is the last good one
  /// Of tick, pressure, state, unresolved ticks and fault, at this tick and at all before it. Two runs with
  /// the same one went the same way.
  std::uint64_t state_hash = 0;
};

}  // namespace servohil::simulation
