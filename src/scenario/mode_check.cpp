#include "scenario/mode_check.hpp"

#include "base/formatted.hpp"
#include "model/ticks.hpp"

namespace servohil::scenario {

void ModeCheck::Take(std::uint64_t tick, double /*value*/, simulation::Mode mode) {
  const Expectation& e = expectation_;
  if (tick > e.to_tick) return;
  last_ = mode;
  const bool is = mode == e.mode;
  if (tick <= e.from_tick) before_ = is;
  if (is && tick >= e.from_tick && !first_) first_ = tick;
}

Finding ModeCheck::Find() const {
  const Expectation& e = expectation_;
  const char* name = simulation::NameOf(e.mode);
  if (e.kind == Expectation::Kind::kModeNever) {
    if (!first_) return {Outcome::kPass, false, "it never was"};
    return {Outcome::kFail,
            true,
            base::Formatted("it was %s at %.4f s", name, model::SecondsOf(*first_)),
            {},
            first_};
  }
  if (before_) {
    return {Outcome::kFail,
            true,
            base::Formatted("it was %s before %g s already", name, model::SecondsOf(e.from_tick)),
            {},
            e.from_tick};
  }
  const double limit_ms = model::SecondsOf(e.to_tick - e.from_tick) * 1e3;
  if (!first_)
    return {Outcome::kFail,
            false,
            base::Formatted("it was %s at %.4f s still; limit %g ms", simulation::NameOf(last_),
                            model::SecondsOf(e.to_tick), limit_ms),
            {},
            e.to_tick};
  const double after_ms = model::SecondsOf(*first_ - e.from_tick) * 1e3;
  return {Outcome::kPass, true, base::Formatted("after %.1f ms", after_ms), after_ms, first_};
}

}  // namespace servohil::scenario
