#include "fault/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "model/step.hpp"

namespace servohil::fault {
namespace {

bool Delays(const Injection& injection) noexcept {
  return injection.id == kSensorDelayed;
}

bool Acts(const Injection& injection, std::uint64_t tick) noexcept {
  return Find(injection.id)->HasSignal() && injection.ShareAt(tick) > 0.0;
}

}  // namespace

bool Sensors::Act(const Schedule& schedule, std::uint64_t tick) noexcept {
  return std::any_of(schedule.begin(), schedule.end(), [&](const Injection& i) { return Acts(i, tick); });
}

bool Sensors::Remember(const Schedule& schedule) noexcept {
  return std::any_of(schedule.begin(), schedule.end(), Delays);
}

const Sensors::History* Sensors::HistoryOf(std::uint8_t quantity) const noexcept {
  const auto found = std::find_if(histories_.begin(), histories_.end(),
                                  [&](const History& h) { return h.used && h.quantity == quantity; });
  return found == histories_.end() ? nullptr : &*found;
}

void Sensors::Note(std::uint8_t quantity, std::uint64_t tick, double truth) noexcept {
  const auto is_its = [&](const History& h) { return h.used && h.quantity == quantity; };
  auto history = std::find_if(histories_.begin(), histories_.end(), is_its);
  if (history == histories_.end())
    history = std::find_if(histories_.begin(), histories_.end(), [](const History& h) { return !h.used; });
  if (history == histories_.end()) return;  // there are as many as injections
  history->used = true;
  history->quantity = quantity;
  history->values[tick % kHistoryTicks] = truth;
}

/// Those of faults that are gone.
void Sensors::Forget(const Schedule& schedule) noexcept {
  for (History& history : histories_) {
    history.used = history.used && std::any_of(schedule.begin(), schedule.end(), [&](const Injection& i) {
                     return Delays(i) && i.target == history.quantity;
                   });
  }
}

double Sensors::Apply(const Injection& injection, std::uint64_t tick, double value) const noexcept {
  const std::uint64_t since_start = injection.TicksSinceStart(tick);
  Reading reading{value, injection.held, value, static_cast<double>(since_start) * model::kTickS};
  if (const History* history = Delays(injection) ? HistoryOf(injection.target) : nullptr) {
    const auto delay = static_cast<std::uint64_t>(std::llround(injection.values[0] / model::kTickS));
    reading.delayed = history->values[(tick - std::min(delay, since_start)) % kHistoryTicks];
  }
  Random random(injection.seed, injection.id, injection.target, tick);
  std::get<SensorAct>(Find(injection.id)->act)(reading, injection.values, injection.ShareAt(tick), random);
  return reading.value;
}

void Sensors::Observe(Schedule& schedule, std::uint64_t tick, std::span<const double> truth) noexcept {
  Forget(schedule);
  for (Injection& injection : schedule.All()) {
    if (!Acts(injection, tick)) continue;
    if (Delays(injection)) Note(injection.target, tick, truth[injection.target]);
    if (!injection.StartsAt(tick)) continue;
    injection.held = truth[injection.target];
    for (const Injection* before = schedule.begin(); before != &injection; ++before) {
      if (before->target == injection.target && Acts(*before, tick))
        injection.held = Apply(*before, tick, injection.held);
    }
  }
}

void Sensors::Measure(const Schedule& schedule, std::uint64_t tick, std::span<const double> truth,
                      std::span<double> measured) const noexcept {
  std::copy(truth.begin(), truth.end(), measured.begin());
  for (const Injection& injection : schedule) {
    if (Acts(injection, tick))
      measured[injection.target] = Apply(injection, tick, measured[injection.target]);
  }
}

}  // namespace servohil::fault
