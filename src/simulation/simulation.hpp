#pragma once
/// The one class with the one Tick(): the same code in real time, offline and in the tests.
/// Links model and fault only; no clock, no thread, no I/O.

#include <cmath>
#include <cstdint>

#include "fault/schedule.hpp"
#include "model/derived.hpp"
#include "model/reconcile.hpp"
#include "model/servomotor.hpp"
#include "model/steady_state.hpp"
#include "model/step.hpp"
#include "simulation/sample.hpp"
#include "simulation/state_hash.hpp"

namespace servohil::simulation {

class Simulation {
 public:
  /// Begins at rest at `start`.
  Simulation(const model::Parameters& parameters, const model::SteadyState& start) noexcept
      : unfaulted_(parameters), derived_(parameters), sample_{.p1_psi = start.p1_psi, .state = start.state} {}

  /// Advances 0.1 ms under constant P1 [psi]. A P1 or a state that is not finite, or a state outside the
  /// model's domain, is not taken over: the last good one stays, and the fault is latched. Real-time safe.
  const Sample& Tick(double p1_psi) noexcept {
    ++sample_.tick;
    sample_.sub_steps = 0;
    if (faults_.Advance(sample_.tick)) FollowFaults(p1_psi);
    if (!sample_.model_fault) Advance(p1_psi);
    ExtendStateHash(sample_);
    return sample_;
  }

  /// Lets 0.1 ms pass at rest, as before the first command: faults pass, too, and act from then on. Real-time
  /// safe.
  const Sample& Rest() noexcept {
    ++sample_.tick;
    if (faults_.Advance(sample_.tick)) FollowFaults(sample_.p1_psi);
    ExtendStateHash(sample_);
    return sample_;
  }

  const Sample& Now() const noexcept { return sample_; }
  /// Flows and relay positions now. Real-time safe.
  model::Outputs Outputs() const noexcept {
    return model::ComputeOutputs(derived_, sample_.state, sample_.p1_psi);
  }

  /// To be changed between ticks.
  fault::Schedule& Faults() noexcept { return faults_; }
  const fault::Schedule& Faults() const noexcept { return faults_; }

  /// Goes on from there, bit for bit as if it had never ended.
  void Restore(const Sample& sample, const fault::Schedule& faults) noexcept {
    sample_ = sample;
    faults_ = faults;
    derived_ = model::Derived(faults_.Faulted(unfaulted_, sample_.tick));
  }

 private:
  void Advance(double p1_psi) noexcept {
    const model::StepResult next = model::Step(derived_, sample_.state, p1_psi);
    if (std::isfinite(p1_psi) && model::IsInDomain(derived_, next.state)) {
      sample_.state = next.state;
      sample_.p1_psi = p1_psi;
      sample_.sub_steps = next.sub_steps;
      if (!next.resolved) ++sample_.unresolved_ticks;
    } else {
      sample_.model_fault = true;
    }
  }
  void FollowFaults(double p1_psi) noexcept {
    derived_ = model::Derived(faults_.Faulted(unfaulted_, sample_.tick));
    sample_.state = model::Reconciled(derived_, sample_.state, p1_psi);
  }

  const model::Parameters unfaulted_;
  model::Derived derived_;
  fault::Schedule faults_;
  Sample sample_;
};

}  // namespace servohil::simulation
