#include "mode_check.hpp"

#include "formatted.hpp"
#include "servohil/app/ticks.hpp"

namespace servohil::app::scenario {

void ModeCheck::Take(std::uint64_t tick, double /*value*/, Mode mode) {
  const Expectation& e = expectation_;
  if (tick > e.to_tick) return;
  last_ = mode;
  const bool is = mode == e.mode;
  if (tick <= e.from_tick) before_ = is;
  if (is && tick >= e.from_tick && !first_) first_ = tick;
}

Finding ModeCheck::Find() const {
  const Expectation& e = expectation_;
  const char* name = app::NameOf(e.mode);
  if (e.kind == Expectation::Kind::kModeNever) {
    if (!first_) return {Outcome::kPass, false, "it never was"};
    return {Outcome::kFail, true, Formatted("it was %s at %.4f s", name, SecondsOf(*first_)), {}, first_};
  }
  if (before_) {
    return {Outcome::kFail,
            true,
            Formatted("it was %s before %g s already", name, SecondsOf(e.from_tick)),
            {},
            e.from_tick};
  }
  const double limit_ms = SecondsOf(e.to_tick - e.from_tick) * 1e3;
  if (!first_)
    return {Outcome::kFail,
            false,
            Formatted("it was %s at %.4f s still; limit %g ms", app::NameOf(last_), SecondsOf(e.to_tick),
                      limit_ms),
            {},
            e.to_tick};
  const double after_ms = SecondsOf(*first_ - e.from_tick) * 1e3;
  return {Outcome::kPass, true, Formatted("after %.1f ms", after_ms), after_ms, first_};
}

}  // namespace servohil::app::scenario
