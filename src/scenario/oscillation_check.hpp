#pragma once
/// Whether a quantity is calm, or oscillates.

#include "scenario/check.hpp"

namespace servohil::scenario {

/// kCalm: from its largest to its smallest value in the time, whatever lies between them.
class CalmCheck : public Check {
 public:
  explicit CalmCheck(const Expectation& expectation) : expectation_(expectation) {}
  void Take(std::uint64_t tick, double value, simulation::Mode mode) override;
  Finding Find() const override;

 private:
  const Expectation& expectation_;
  bool any_ = false;
  double least_ = 0.0;
  double most_ = 0.0;
  std::uint64_t least_tick_ = 0;
  std::uint64_t most_tick_ = 0;
  std::optional<std::uint64_t> broken_tick_;
};

/// Turning points of a quantity between which it moves by at least so much: less is not seen as a swing.
class Swings {
 public:
  explicit Swings(double least_swing) : least_swing_(least_swing) {}
  void Take(std::uint64_t tick, double value);

  std::uint64_t LoopIterations() const { return loop_iterations_; }
  /// Of the time between the first and the last turn; 0 with fewer than three.
  double FrequencyHz() const;
  /// Without a turn: between two, before the first, or after the last until `tick`.
  std::uint64_t LongestPause(std::uint64_t tick) const;
  double LargestSwing() const { return largest_; }

 private:
  void Turn(std::uint64_t tick, double value);

  double least_swing_;
  bool any_ = false;
  int direction_ = 0;  ///< 0: not known yet
  double least_ = 0.0;
  double most_ = 0.0;
  std::uint64_t least_tick_ = 0;
  std::uint64_t most_tick_ = 0;
  std::uint64_t begin_tick_ = 0;
  std::uint64_t loop_iterations_ = 0;
  std::uint64_t first_turn_ = 0;
  std::uint64_t last_turn_ = 0;
  double last_value_ = 0.0;
  std::uint64_t longest_pause_ = 0;
  double largest_ = 0.0;
};

/// kOscillates: it swings, and never rests for a quarter of the time.
class OscillationCheck : public Check {
 public:
  explicit OscillationCheck(const Expectation& expectation)
      : expectation_(expectation), swings_(expectation.peak_to_peak) {}
  void Take(std::uint64_t tick, double value, simulation::Mode mode) override;
  Finding Find() const override;

 private:
  const Expectation& expectation_;
  Swings swings_;
  bool any_ = false;
  double least_ = 0.0;
  double most_ = 0.0;
};

}  // namespace servohil::scenario
