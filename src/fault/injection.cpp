#include "fault/injection.hpp"

#include <algorithm>

namespace servohil::fault {
namespace {

/// How many pulses have begun before that of `since_start`.
std::uint64_t PulseAt(const Injection& i, std::uint64_t since_start) noexcept {
  if (i.period_ticks == 0) return 0;
  const std::uint64_t pulse = since_start / i.period_ticks;
  return i.times == 0 ? pulse : std::min<std::uint64_t>(pulse, i.times - 1);
}

/// `since` ticks after the first of a pulse. The first has something of it already.
double PulseShare(const Injection& i, std::uint64_t since) noexcept {
  const auto risen = [&](std::uint64_t ticks) noexcept {
    return i.ramp_ticks == 0 ? 1.0
                             : std::min(1.0, static_cast<double>(ticks) / static_cast<double>(i.ramp_ticks));
  };
  if (i.for_ticks == 0 || since < i.for_ticks) return risen(since + 1);
  if (i.ramp_out_ticks == 0) return 0.0;
  const double fallen = static_cast<double>(since - i.for_ticks + 1) / static_cast<double>(i.ramp_out_ticks);
  return std::max(0.0, risen(i.for_ticks) - fallen);
}

}  // namespace

std::uint64_t Injection::TicksSinceStart(std::uint64_t tick) const noexcept {
  const std::uint64_t since_start = tick - start_tick;
  return since_start - PulseAt(*this, since_start) * period_ticks;
}

double Injection::ShareAt(std::uint64_t tick) const noexcept {
  return waits || tick < start_tick ? 0.0 : PulseShare(*this, TicksSinceStart(tick));
}

bool Injection::IsOverAt(std::uint64_t tick) const noexcept {
  const bool endless = for_ticks == 0 || (period_ticks != 0 && times == 0);
  if (waits || endless) return false;
  const std::uint64_t last = period_ticks == 0 ? 0 : (times - 1) * period_ticks;
  return tick >= start_tick + last + for_ticks + ramp_out_ticks;
}

bool Injection::StartsAt(std::uint64_t tick) const noexcept {
  return ShareAt(tick) > 0.0 && TicksSinceStart(tick) == 0;
}

void Injection::Fire(std::uint64_t first_tick) noexcept {
  waits = false;
  ++fired;
  start_tick = first_tick;
}

bool Injection::FiresAgain() const noexcept {
  return trigger.kind != Trigger::Kind::kTime && period_ticks == 0 && (times == 0 || fired < times);
}

}  // namespace servohil::fault
