#include "emulator/command_validator.hpp"
#include "base/clock.hpp"

#include <algorithm>
#include <cmath>

namespace servohil::emulator {
namespace {

constexpr double kRounding = 1.0 + 1e-9;  // of a rate, in doubles
// A change that is meant to be within a rate comes out larger by less than a step of the signal.
constexpr double kLessThanAStep = 1.0 - 1e-3;

simulation::FrameVerdict VerdictOf(can::E2eVerdict verdict) noexcept {
  switch (verdict) {
    case can::E2eVerdict::kCorrupted:
      return simulation::FrameVerdict::kCorrupted;
    case can::E2eVerdict::kRepeated:
      return simulation::FrameVerdict::kRepeated;
    case can::E2eVerdict::kStuck:
      return simulation::FrameVerdict::kStuck;
    case can::E2eVerdict::kReordered:
      return simulation::FrameVerdict::kReordered;
    case can::E2eVerdict::kTooMany:
      return simulation::FrameVerdict::kJumped;
    default:
      return simulation::FrameVerdict::kValid;
  }
}

/// Of a frame without P1.
simulation::FrameVerdict VerdictOf(signal_map::CommandRejection why) noexcept {
  switch (why) {
    case signal_map::CommandRejection::kNotAvailable:
      return simulation::FrameVerdict::kNotAvailable;
    case signal_map::CommandRejection::kErrorIndicator:
      return simulation::FrameVerdict::kErrorIndicator;
    default:
      return simulation::FrameVerdict::kOutOfRange;
  }
}

}  // namespace

CommandValidator::CommandValidator(const configuration::SafetySettings& settings, int cycle_ms) noexcept
    : settings_(settings), cycle_s_(cycle_ms / 1e3) {}

simulation::FrameVerdict CommandValidator::Judge(const can::Frame& frame,
                                                 const std::optional<signal_map::Demand>& demand,
                                                 signal_map::CommandRejection why,
                                                 const FrameTime& time) noexcept {
  simulation::FrameVerdict verdict = simulation::FrameVerdict::kMalformed;
  if (why != signal_map::CommandRejection::kMalformed) {
    // The sequence first: a frame that is refused for its value or age was none the less the next one.
    verdict = JudgeSequence(frame);
    if (verdict == simulation::FrameVerdict::kValid && IsStale(time))
      verdict = simulation::FrameVerdict::kStale;
  }
  if (verdict == simulation::FrameVerdict::kValid && demand) TakeCondition(*demand, time);
  if (verdict == simulation::FrameVerdict::kValid)
    verdict = demand && demand->p1_psi ? JudgeValue(*demand, time) : VerdictOf(why);
  ++newest_.counts.Of(verdict);
  if (verdict == simulation::FrameVerdict::kValid) {
    Follow(WithinLimits(*demand->p1_psi), time);
  } else {
    newest_.good_in_a_row = 0;
  }
  return verdict;
}

/// A wrong P1 takes nothing from a trip in the same frame.
void CommandValidator::TakeCondition(const signal_map::Demand& demand, const FrameTime& time) noexcept {
  if (IsStale(time)) return;
  newest_.enabled = demand.enabled.value_or(newest_.enabled);
  newest_.trip = demand.trip.value_or(newest_.trip);
  if (demand.trip.value_or(false)) ++newest_.trips;
  if (!demand.enabled.value_or(true)) ++newest_.disablings;
  if (!newest_.enabled || newest_.trip) newest_.good_in_a_row = 0;
}

bool CommandValidator::IsStale(const FrameTime& time) const noexcept {
  return settings_.max_age_ms != 0 && time.age_ns > settings_.max_age_ms * base::kNsPerMs;
}

simulation::FrameVerdict CommandValidator::JudgeSequence(const can::Frame& frame) noexcept {
  if (!checker_) return simulation::FrameVerdict::kValid;
  const can::E2eVerdict verdict = checker_->Check(frame.id, {frame.data.data(), frame.size});
  newest_.counts.lost = checker_->Counters().lost_frames;
  return VerdictOf(verdict);
}

// What a frame can say of a limit is the value next to it: beyond it by less than its resolution, it is the
// limit.
simulation::FrameVerdict CommandValidator::JudgeValue(const signal_map::Demand& demand,
                                                      const FrameTime& time) const noexcept {
  const double p1_psi = WithinLimits(*demand.p1_psi);
  if (!(std::fabs(*demand.p1_psi - p1_psi) <= demand.p1_rounding_psi))
    return simulation::FrameVerdict::kOutOfRange;
  if (settings_.p1_rate_psi_s > 0.0 && newest_.counts.Valid() > 0) {
    const double elapsed_s = std::max(
        cycle_s_, static_cast<double>(time.time_ns - newest_time_ns_) / static_cast<double>(base::kNsPerS));
    const double allowed_psi =
        settings_.p1_rate_psi_s * elapsed_s * kRounding + 2.0 * demand.p1_rounding_psi * kLessThanAStep;
    if (std::fabs(p1_psi - newest_.p1_psi) > allowed_psi) return simulation::FrameVerdict::kTooFast;
  }
  return simulation::FrameVerdict::kValid;
}

double CommandValidator::WithinLimits(double p1_psi) const noexcept {
  return std::clamp(p1_psi, settings_.p1_minimum_psi, settings_.p1_maximum_psi);
}

void CommandValidator::Follow(double p1_psi, const FrameTime& time) noexcept {
  newest_.p1_psi = p1_psi;
  newest_.arrival_ns = time.arrival_ns;
  newest_time_ns_ = time.time_ns;
  if (!newest_.enabled || newest_.trip) return;
  ++newest_.good;
  ++newest_.good_in_a_row;
}

CommandValidator ValidatorOf(const signal_map::SignalMap& signal_map,
                             const configuration::SafetySettings& settings, int cycle_ms,
                             int max_counter_jump) {
  CommandValidator validator(settings, cycle_ms);
  const signal_map::ReceivedMessage& command = signal_map.IncomingMessages().front();
  if (command.protection) validator.Check(*command.protection, static_cast<unsigned>(max_counter_jump));
  if (signal_map.HasEnable()) validator.AwaitEnable();
  return validator;
}

}  // namespace servohil::emulator
