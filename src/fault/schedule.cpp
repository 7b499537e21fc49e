#include "servohil/fault/schedule.hpp"

#include <algorithm>

#include "servohil/model/step.hpp"

namespace servohil::fault {

double Injection::ShareAt(std::uint64_t tick) const noexcept {
  if (tick < start_tick || IsOverAt(tick)) return 0.0;
  const auto after = [](std::uint64_t now, std::uint64_t begin) noexcept {
    return static_cast<double>(now - begin + 1);
  };
  const auto ramp = static_cast<double>(ramp_ticks);
  const double in = ramp_ticks == 0 ? 1.0 : std::min(1.0, after(tick, start_tick) / ramp);
  const std::uint64_t end_tick = start_tick + for_ticks;
  if (for_ticks == 0 || tick < end_tick) return in;
  const double at_end = ramp_ticks == 0 ? 1.0 : std::min(1.0, static_cast<double>(for_ticks) / ramp);
  return std::max(0.0, at_end - after(tick, end_tick) / ramp);  // over at once where there is no ramp
}

bool Injection::IsOverAt(std::uint64_t tick) const noexcept {
  return for_ticks != 0 && tick >= start_tick + for_ticks + ramp_ticks;
}

bool Schedule::Inject(const Injection& injection) noexcept {
  Clear(injection.id);
  if (count_ == kMostInjections) return false;
  auto* const place = std::upper_bound(
      injections_.data(), injections_.data() + count_, injection,
      [](const Injection& one, const Injection& other) noexcept { return Find(one.id) < Find(other.id); });
  std::copy_backward(place, injections_.data() + count_, injections_.data() + count_ + 1);
  *place = injection;
  ++count_;
  changed_ = true;
  return true;
}

void Schedule::Remove(std::size_t index) noexcept {
  std::copy(injections_.begin() + static_cast<std::ptrdiff_t>(index) + 1,
            injections_.begin() + static_cast<std::ptrdiff_t>(count_),
            injections_.begin() + static_cast<std::ptrdiff_t>(index));
  --count_;
  changed_ = true;
}

std::size_t Schedule::Clear(std::uint8_t id) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (injections_[i].id != id) continue;
    Remove(i);
    return 1;
  }
  return 0;
}

std::size_t Schedule::ClearAll() noexcept {
  const std::size_t were = count_;
  count_ = 0;
  changed_ = changed_ || were > 0;
  return were;
}

bool Schedule::Advance(std::uint64_t tick) noexcept {
  for (std::size_t i = count_; i-- > 0;) {
    if (injections_[i].IsOverAt(tick)) Remove(i);
  }
  bool differs = changed_;
  changed_ = false;
  for (const Injection& injection : *this) {
    const double share = injection.ShareAt(tick);
    const bool moves = tick > 0 && share != injection.ShareAt(tick - 1);
    differs = differs || moves || (share > 0.0 && Find(injection.id)->varies);
  }
  return differs;
}

model::Parameters Schedule::Faulted(const model::Parameters& unfaulted, std::uint64_t tick) const noexcept {
  model::Parameters p = unfaulted;
  for (const Injection& injection : *this) {
    const double share = injection.ShareAt(tick);
    if (share == 0.0) continue;
    const double t_s = static_cast<double>(tick - injection.start_tick) * model::kTickS;
    Find(injection.id)->act(p, injection.values, share, t_s);
  }
  return p;
}

std::size_t Schedule::CountActive(std::uint64_t tick) const noexcept {
  return static_cast<std::size_t>(
      std::count_if(begin(), end(), [&](const Injection& i) { return i.ShareAt(tick) > 0.0; }));
}

}  // namespace servohil::fault
