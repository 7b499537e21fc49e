#include "simulation/command_monitor.hpp"

#include <algorithm>
#include <utility>

#include "model/step.hpp"
#include "model/ticks.hpp"

namespace servohil::simulation {
namespace {

constexpr double kDrainedPsi = 1e-3;  // a fifth of what SERVO_Pressures.P1_Applied resolves

/// Of x' = −x/τ in one tick, implicit Euler; τ = 0: at once.
double DrainFactor(double time_constant_s) noexcept {
  return time_constant_s / (time_constant_s + model::kTickS);
}

double Drained(double p1_psi, double factor) noexcept {
  const double next_psi = p1_psi * factor;
  return next_psi < kDrainedPsi ? 0.0 : next_psi;
}

}  // namespace

SafetyLaw LawOf(const configuration::SafetySettings& settings) noexcept {
  return {static_cast<std::uint64_t>(std::max(settings.timeout_ms, 0)) * model::kTicksPerMs, settings.on_loss,
          DrainFactor(settings.drain_time_constant_s), DrainFactor(settings.trip_time_constant_s),
          static_cast<std::uint64_t>(settings.recover_after)};
}

bool CommandMonitor::Hear(const Command& newest, bool fresh_enough) noexcept {
  const bool valid = fresh_enough && newest.counts.Valid() > heard_.counts.Valid();
  heard_ = newest;
  if (!valid) return false;
  fresh_ = true;
  now_.silent_ticks = 0;
  rejected_at_valid_ = newest.counts.Rejected();
  return true;
}

std::optional<CommandMonitor::Decision> CommandMonitor::Decide(bool counts) noexcept {
  const bool fresh = std::exchange(fresh_, false);
  const bool trips = heard_.trips > std::exchange(trips_seen_, heard_.trips);
  // However short: what a later frame of the same tick says takes nothing from it.
  const bool disabled =
      heard_.disablings > std::exchange(disablings_seen_, heard_.disablings) || !heard_.enabled;
  if (counts && !fresh) ++now_.silent_ticks;
  switch (now_.state) {
    case SafetyState::kWaiting:
      return WhileWaiting(fresh, trips);
    case SafetyState::kRunning:
      return WhileRunning(trips, disabled);
    case SafetyState::kDegraded:
    case SafetyState::kTripped:
      return WhileStopped(trips);
    default:
      return std::nullopt;
  }
}

std::optional<CommandMonitor::Decision> CommandMonitor::WhileWaiting(bool fresh, bool trips) const noexcept {
  if (trips) return Decision{SafetyState::kTripped, SafetyCause::kTrip};
  if (fresh && heard_.enabled) return Decision{SafetyState::kRunning, SafetyCause::kCommand};
  return std::nullopt;
}

std::optional<CommandMonitor::Decision> CommandMonitor::WhileRunning(bool trips,
                                                                     bool disabled) const noexcept {
  if (trips) return Decision{SafetyState::kTripped, SafetyCause::kTrip};
  if (!now_.governed) return std::nullopt;
  if (disabled) return Decision{SafetyState::kDegraded, SafetyCause::kDisabled};
  if (!IsSilent()) return std::nullopt;
  const bool some_came = heard_.counts.Rejected() > rejected_at_valid_;
  return Decision{SafetyState::kDegraded, some_came ? SafetyCause::kInvalidFrames : SafetyCause::kSilence};
}

/// Valid frames in a row lead on; a pause or a trip begins their count anew.
std::optional<CommandMonitor::Decision> CommandMonitor::WhileStopped(bool trips) noexcept {
  if (trips && now_.state == SafetyState::kDegraded)
    return Decision{SafetyState::kTripped, SafetyCause::kTrip};
  if (trips || IsSilent()) good_at_begin_ = heard_.good;
  if (std::min(heard_.good_in_a_row, heard_.good - good_at_begin_) < law_.recover_after) return std::nullopt;
  return Decision{SafetyState::kRunning, SafetyCause::kRecovered};
}

bool CommandMonitor::IsSilent() const noexcept {
  return law_.timeout_ticks != 0 && now_.silent_ticks >= law_.timeout_ticks;
}

void CommandMonitor::SetDemand(double p1_psi) noexcept {
  now_.demand_psi = p1_psi;
  now_.governed = true;
}

void CommandMonitor::Change(const Decision& decision) noexcept {
  if (now_.state == SafetyState::kFaulted) return;
  if (decision.to == SafetyState::kDegraded) ++now_.losses;
  if (decision.to == SafetyState::kTripped) ++now_.trips;
  now_.state = decision.to;
  now_.cause = decision.cause;
  good_at_begin_ = heard_.good;
}

bool CommandMonitor::TakeLocal(double p1_psi) noexcept {
  if (now_.state == SafetyState::kTripped || now_.state == SafetyState::kFaulted) return false;
  now_.demand_psi = p1_psi;
  now_.governed = false;
  if (now_.state != SafetyState::kRunning) Change({SafetyState::kRunning, SafetyCause::kOperator});
  return true;
}

bool CommandMonitor::Rests() const noexcept {
  return now_.state == SafetyState::kWaiting ||
         (now_.state == SafetyState::kDegraded && law_.on_loss == configuration::OnLoss::kFreeze);
}

double CommandMonitor::P1(double p1_psi) const noexcept {
  switch (now_.state) {
    case SafetyState::kRunning:
      return now_.demand_psi;
    case SafetyState::kDegraded:
      return law_.on_loss == configuration::OnLoss::kDrain ? Drained(p1_psi, law_.drain_factor) : p1_psi;
    case SafetyState::kTripped:
      return Drained(p1_psi, law_.trip_factor);
    default:
      return p1_psi;
  }
}

}  // namespace servohil::simulation
