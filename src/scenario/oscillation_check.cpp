#include "scenario/oscillation_check.hpp"

#include <algorithm>
#include <cmath>

#include "base/formatted.hpp"
#include "model/ticks.hpp"

namespace servohil::scenario {

void CalmCheck::Take(std::uint64_t tick, double value, simulation::Mode /*mode*/) {
  const Expectation& e = expectation_;
  if (tick < e.from_tick || tick > e.to_tick) return;
  if (!any_ || value < least_) least_ = value, least_tick_ = tick;
  if (!any_ || value > most_) most_ = value, most_tick_ = tick;
  any_ = true;
  if (!(most_ - least_ <= e.peak_to_peak) && !broken_tick_) broken_tick_ = tick;
}

Finding CalmCheck::Find() const {
  const recording::SampleColumn& quantity = *expectation_.quantity;
  const double swing = most_ - least_;
  std::string text = WithUnit(swing, quantity) + " peak to peak";
  if (!broken_tick_) return {Outcome::kPass, false, text, swing};
  text += ", from " + WithUnit(least_, quantity) +
          base::Formatted(" at %.4f s", model::SecondsOf(least_tick_)) + " to " + WithUnit(most_, quantity) +
          base::Formatted(" at %.4f s; above the limit from %.4f s on; limit ", model::SecondsOf(most_tick_),
                          model::SecondsOf(*broken_tick_)) +
          WithUnit(expectation_.peak_to_peak, quantity);
  return {Outcome::kFail, true, text, swing, broken_tick_};
}

void Swings::Take(std::uint64_t tick, double value) {
  if (!any_) {
    any_ = true;
    begin_tick_ = tick;
    least_ = most_ = value;
    least_tick_ = most_tick_ = tick;
  }
  if (value > most_) most_ = value, most_tick_ = tick;
  if (value < least_) least_ = value, least_tick_ = tick;
  if (direction_ <= 0 && value - least_ >= least_swing_) {  // it has turned upward at its least
    if (direction_ < 0) Turn(least_tick_, least_);
    direction_ = 1;
    most_ = value, most_tick_ = tick;
  } else if (direction_ >= 0 && most_ - value >= least_swing_) {
    if (direction_ > 0) Turn(most_tick_, most_);
    direction_ = -1;
    least_ = value, least_tick_ = tick;
  }
}

void Swings::Turn(std::uint64_t tick, double value) {
  longest_pause_ = std::max(longest_pause_, tick - (loop_iterations_ == 0 ? begin_tick_ : last_turn_));
  if (loop_iterations_ == 0) {
    first_turn_ = tick;
  } else {
    largest_ = std::max(largest_, std::fabs(value - last_value_));
  }
  ++loop_iterations_;
  last_turn_ = tick;
  last_value_ = value;
}

double Swings::FrequencyHz() const {
  if (loop_iterations_ < 3) return 0.0;
  return static_cast<double>(loop_iterations_ - 1) / 2.0 / model::SecondsOf(last_turn_ - first_turn_);
}

std::uint64_t Swings::LongestPause(std::uint64_t tick) const {
  return std::max(longest_pause_, tick - (loop_iterations_ == 0 ? begin_tick_ : last_turn_));
}

void OscillationCheck::Take(std::uint64_t tick, double value, simulation::Mode /*mode*/) {
  const Expectation& e = expectation_;
  if (tick < e.from_tick || tick > e.to_tick) return;
  least_ = any_ ? std::min(least_, value) : value;
  most_ = any_ ? std::max(most_, value) : value;
  any_ = true;
  swings_.Take(tick, value);
}

Finding OscillationCheck::Find() const {
  const Expectation& e = expectation_;
  const std::uint64_t pause = swings_.LongestPause(e.to_tick);
  if (swings_.LoopIterations() < 3 || pause > (e.to_tick - e.from_tick) / 4) {
    return {Outcome::kFail, false,
            WithUnit(most_ - least_, *e.quantity) + " from its least to its most, " +
                base::Formatted("%llu turns of a swing of at least ",
                                static_cast<unsigned long long>(swings_.LoopIterations())) +
                WithUnit(e.peak_to_peak, *e.quantity) +
                base::Formatted(", none for %g s; limit a quarter of the time", model::SecondsOf(pause)),
            most_ - least_};
  }
  const double frequency_hz = swings_.FrequencyHz();
  const std::string text = WithUnit(swings_.LargestSwing(), *e.quantity) +
                           base::Formatted(" peak to peak at %.2f Hz", frequency_hz);
  if (frequency_hz >= e.lowest_hz && frequency_hz <= e.highest_hz)
    return {Outcome::kPass, false, text, swings_.LargestSwing()};
  return {Outcome::kFail, false, text + base::Formatted("; limits %g and %g Hz", e.lowest_hz, e.highest_hz),
          frequency_hz};
}

}  // namespace servohil::scenario
