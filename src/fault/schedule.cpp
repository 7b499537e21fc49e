#include "fault/schedule.hpp"

#include <algorithm>

#include "model/step.hpp"

namespace servohil::fault {

namespace {

/// Looks at the truth after each tick, while it waits and while its next firing must be told from this one.
bool FollowsCondition(const Injection& i) noexcept {
  return i.trigger.kind == Trigger::Kind::kCondition && (i.waits || i.FiresAgain());
}

bool WaitsFor(const Injection& i, std::uint32_t id, bool extended) noexcept {
  return i.waits && i.trigger.kind == Trigger::Kind::kFrame && i.trigger.frame_id == id &&
         i.trigger.extended == extended;
}

/// The catalogue's order, and of one fault that of its targets.
bool Before(const Injection& one, const Injection& other) noexcept {
  return one.id == other.id ? one.target < other.target : Find(one.id) < Find(other.id);
}

std::uint32_t PulseOf(const Injection& i, std::uint64_t tick) noexcept {
  if (i.period_ticks == 0) return i.fired == 0 ? 0 : i.fired - 1;
  return static_cast<std::uint32_t>((tick - i.TicksSinceStart(tick) - i.start_tick) / i.period_ticks);
}

}  // namespace

bool Schedule::Inject(const Injection& injection, std::uint64_t next_tick) noexcept {
  const Spec* spec = Find(injection.id);
  if (spec == nullptr || (spec->HasSignal() && injection.target == Injection::kEverything)) return false;
  const auto same = std::find_if(begin(), end(), [&](const Injection& one) {
    return one.id == injection.id && one.target == injection.target;
  });
  const bool is_there = same != end();
  if (is_there) Remove(static_cast<std::size_t>(same - begin()));
  if (count_ == kMaxInjections) return false;
  auto* const place = std::upper_bound(injections_.data(), injections_.data() + count_, injection, Before);
  std::copy_backward(place, injections_.data() + count_, injections_.data() + count_ + 1);
  *place = injection;
  ++count_;
  changed_ = changed_ || spec->ActsAs<ParameterAct>();
  if (is_there) {
    Tell(Event::Kind::kChanged, injection, next_tick);
  } else if (injection.waits || injection.start_tick > next_tick) {
    Tell(Event::Kind::kWaits, injection, next_tick);
  }
  return true;
}

void Schedule::Remove(std::size_t index) noexcept {
  changed_ = changed_ || Find(injections_[index].id)->ActsAs<ParameterAct>();
  std::copy(injections_.begin() + static_cast<std::ptrdiff_t>(index) + 1,
            injections_.begin() + static_cast<std::ptrdiff_t>(count_),
            injections_.begin() + static_cast<std::ptrdiff_t>(index));
  --count_;
}

std::size_t Schedule::Clear(std::uint8_t id, std::uint8_t target, std::uint64_t next_tick) noexcept {
  const std::size_t were = count_;
  for (std::size_t i = count_; i-- > 0;) {
    const Injection& one = injections_[i];
    if (one.id != id || (target != Injection::kEverything && one.target != target)) continue;
    Tell(Event::Kind::kCleared, one, next_tick);
    Remove(i);
  }
  return were - count_;
}

std::size_t Schedule::ClearAll(std::uint64_t next_tick) noexcept {
  const std::size_t were = count_;
  while (count_ > 0) {
    Tell(Event::Kind::kCleared, injections_[count_ - 1], next_tick);
    Remove(count_ - 1);
  }
  return were;
}

void Schedule::Tell(Event::Kind kind, const Injection& injection, std::uint64_t tick) noexcept {
  if (event_count_ == kMaxEvents) return;
  const bool has_pulse = kind == Event::Kind::kStarts || kind == Event::Kind::kEnds;
  events_[event_count_++] = {tick, kind, injection.id, injection.target,
                             has_pulse ? PulseOf(injection, tick) : 0};
}

void Schedule::TellTransitions(std::uint64_t tick) noexcept {
  for (const Injection& injection : *this) {
    const bool acts = injection.ShareAt(tick) > 0.0;
    const bool acted = tick > 0 && injection.ShareAt(tick - 1) > 0.0;
    if (acts != acted) Tell(acts ? Event::Kind::kStarts : Event::Kind::kEnds, injection, tick);
  }
}

/// What begins now starts others with the next tick.
void Schedule::FireOnFaults(std::uint64_t tick) noexcept {
  for (const Event& event : Events()) {
    if (event.kind != Event::Kind::kStarts || event.tick != tick) continue;
    for (Injection& one : All()) {
      if (one.waits && one.trigger.kind == Trigger::Kind::kFault && one.trigger.fault == event.id &&
          tick + 1 >= one.start_tick)
        one.Fire(tick + 1);
    }
  }
}

bool Schedule::Advance(std::uint64_t tick) noexcept {
  TellTransitions(tick);
  for (std::size_t i = count_; i-- > 0;) {
    if (!injections_[i].IsOverAt(tick)) continue;
    if (injections_[i].FiresAgain()) {
      injections_[i].waits = true;
    } else {
      Remove(i);
    }
  }
  FireOnFaults(tick);
  bool differs = changed_;
  changed_ = false;
  for (const Injection& injection : *this) {
    const Spec& spec = *Find(injection.id);
    if (!spec.ActsAs<ParameterAct>()) continue;
    const double share = injection.ShareAt(tick);
    const bool moves = tick > 0 && share != injection.ShareAt(tick - 1);
    differs = differs || moves || (share > 0.0 && spec.varies);
  }
  return differs;
}

bool Schedule::Observes() const noexcept {
  return std::any_of(begin(), end(), FollowsCondition);
}

void Schedule::Observe(std::uint64_t tick, std::span<const double> truth) noexcept {
  for (Injection& one : All()) {
    if (!FollowsCondition(one) || tick + 1 < one.start_tick) continue;
    const double value = truth[one.trigger.quantity];
    const bool is_true = one.trigger.above ? value > one.trigger.threshold : value < one.trigger.threshold;
    if (one.waits && is_true && !one.was_true) one.Fire(tick + 1);
    one.was_true = is_true;
  }
}

bool Schedule::WaitsForFrame(std::uint32_t id, bool extended) const noexcept {
  return std::any_of(begin(), end(), [&](const Injection& one) { return WaitsFor(one, id, extended); });
}

void Schedule::TakeFrame(std::uint32_t id, bool extended, std::uint64_t next_tick) noexcept {
  for (Injection& one : All()) {
    if (WaitsFor(one, id, extended) && next_tick >= one.start_tick) one.Fire(next_tick);
  }
}

model::Parameters Schedule::Faulted(const model::Parameters& unfaulted, std::uint64_t tick) const noexcept {
  model::Parameters p = unfaulted;
  for (const Injection& injection : *this) {
    const double share = injection.ShareAt(tick);
    if (share == 0.0) continue;
    const ParameterAct* act = std::get_if<ParameterAct>(&Find(injection.id)->act);
    if (act == nullptr) continue;
    const double t_s = static_cast<double>(injection.TicksSinceStart(tick)) * model::kTickS;
    (*act)(p, injection.values, share, t_s);
  }
  return p;
}

std::size_t Schedule::CountActive(std::uint64_t tick) const noexcept {
  return static_cast<std::size_t>(
      std::count_if(begin(), end(), [&](const Injection& i) { return i.ShareAt(tick) > 0.0; }));
}

}  // namespace servohil::fault
