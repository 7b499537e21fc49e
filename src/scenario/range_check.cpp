#include "scenario/range_check.hpp"

#include <cmath>

#include "base/formatted.hpp"
#include "model/ticks.hpp"

namespace servohil::scenario {
namespace {

using Kind = Expectation::Kind;

std::string At(std::uint64_t tick) {
  return base::Formatted(" at %.4f s", model::SecondsOf(tick));
}

}  // namespace

RangeCheck::RangeCheck(const Expectation& e)
    : expectation_(e),
      low_(e.kind == Kind::kBetween ? e.above : e.of - e.within),
      high_(e.kind == Kind::kBetween ? e.below : e.of + e.within) {}

void RangeCheck::Take(std::uint64_t tick, double value, simulation::Mode /*mode*/) {
  const Expectation& e = expectation_;
  if (tick > e.to_tick) return;
  const bool inside = value >= low_ && value <= high_;  // what is not a number is outside
  if (!inside) last_outside_ = {tick, value};
  if (tick < e.from_tick) return;
  if (!inside && !first_outside_) first_outside_ = {tick, value};
  if (!least_ || value < least_->value) least_ = {tick, value};
  if (!most_ || value > most_->value) most_ = {tick, value};
}

Finding RangeCheck::Find() const {
  if (!least_) return {Outcome::kPass, false, "nothing was measured"};
  if (expectation_.kind == Kind::kBetween) return FindExtremes();
  return expectation_.kind == Kind::kSettles ? FindSettling() : FindDeviation();
}

Finding RangeCheck::FindDeviation() const {
  const Expectation& e = expectation_;
  const Point worst = most_->value - e.of > e.of - least_->value ? *most_ : *least_;
  const double off = std::fabs(worst.value - e.of);
  const std::string text =
      WithUnit(worst.value, *e.quantity) + At(worst.tick) + ", " + WithUnit(off, *e.quantity) + " off";
  if (!first_outside_) return {Outcome::kPass, false, text, off, worst.tick};
  return {Outcome::kFail, true,
          text + "; first outside" + At(first_outside_->tick) + "; limit " + WithUnit(e.within, *e.quantity),
          off, first_outside_->tick};
}

Finding RangeCheck::FindSettling() const {
  const Expectation& e = expectation_;
  if (!last_outside_) return {Outcome::kPass, false, "it was there all the time", 0.0};
  const double settled_s = model::SecondsOf(last_outside_->tick + 1);
  if (!first_outside_)
    return {Outcome::kPass, false, base::Formatted("settled at %.4f s", settled_s), settled_s,
            last_outside_->tick + 1};
  return {Outcome::kFail, true,
          "last outside" + At(last_outside_->tick) + ", at " + WithUnit(last_outside_->value, *e.quantity) +
              base::Formatted("; limit %g s", model::SecondsOf(e.from_tick)),
          settled_s, first_outside_->tick};
}

Finding RangeCheck::FindExtremes() const {
  const Expectation& e = expectation_;
  if (!first_outside_) {
    return {Outcome::kPass, false,
            WithUnit(least_->value, *e.quantity) + At(least_->tick) + " to " +
                WithUnit(most_->value, *e.quantity) + At(most_->tick),
            std::isfinite(e.below) ? most_->value : least_->value};
  }
  const bool too_low = !(first_outside_->value >= low_);
  const Point worst = too_low ? *least_ : *most_;
  return {Outcome::kFail, true,
          WithUnit(worst.value, *e.quantity) + At(worst.tick) + "; first outside" + At(first_outside_->tick) +
              "; limit " + (too_low ? "above " : "below ") + WithUnit(too_low ? low_ : high_, *e.quantity),
          worst.value, first_outside_->tick};
}

}  // namespace servohil::scenario
