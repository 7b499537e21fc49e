#pragma once
/// The one class with the one Tick(): the same code in real time, offline and in the tests.
/// Links the model only; no clock, no thread, no I/O.

#include <cmath>
#include <cstdint>

#include "servohil/model/derived.hpp"
#include "servohil/model/servomotor.hpp"
#include "servohil/model/steady_state.hpp"
#include "servohil/model/step.hpp"

namespace servohil::app {

/// Where the simulation is after `tick` ticks.
struct Sample {
  std::uint64_t tick = 0;  ///< t = tick * model::kTickS
  double p1_psi = 0.0;     ///< control pressure during the tick that ended here
  model::State state;
  int sub_steps = 0;                   ///< of the tick that ended here
  std::uint64_t unresolved_ticks = 0;  ///< ticks that needed more sub-steps than model::kMaxSubSteps, so far
  bool model_fault = false;            ///< latched: the model left its domain, the state is the last good one
};

class Simulation {
 public:
  /// Begins at rest at `start`.
  Simulation(const model::Derived& derived, const model::SteadyState& start) noexcept
      : derived_(derived), sample_{.p1_psi = start.p1_psi, .state = start.state} {}

  /// Advances 0.1 ms under constant P1 [psi]. A P1 or a state that is not finite, or a state outside the
  /// model's domain, is not taken over: the last good one stays, and the fault is latched. Real-time safe.
  const Sample& Tick(double p1_psi) noexcept {
    ++sample_.tick;
    if (sample_.model_fault) return sample_;
    const model::StepResult next = model::Step(derived_, sample_.state, p1_psi);
    if (std::isfinite(p1_psi) && model::IsInDomain(derived_, next.state)) {
      sample_.state = next.state;
      sample_.p1_psi = p1_psi;
      sample_.sub_steps = next.sub_steps;
      if (!next.resolved) ++sample_.unresolved_ticks;
    } else {
      sample_.model_fault = true;
    }
    return sample_;
  }

  /// Lets 0.1 ms pass at rest, as before the first command. Real-time safe.
  const Sample& Rest() noexcept {
    ++sample_.tick;
    return sample_;
  }

  const Sample& Now() const noexcept { return sample_; }
  /// Flows and relay positions at `sample`. Real-time safe.
  model::Outputs OutputsAt(const Sample& sample) const noexcept {
    return model::ComputeOutputs(derived_, sample.state, sample.p1_psi);
  }

 private:
  const model::Derived derived_;
  Sample sample_;
};

}  // namespace servohil::app
