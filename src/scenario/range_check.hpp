#pragma once
/// Whether a quantity stays between two limits; when it has settled there.

#include "scenario/check.hpp"

namespace servohil::scenario {

/// kWithin, kBetween, kSettles.
class RangeCheck : public Check {
 public:
  explicit RangeCheck(const Expectation& expectation);
  void Take(std::uint64_t tick, double value, simulation::Mode mode) override;
  Finding Find() const override;

 private:
  struct Point {
    std::uint64_t tick = 0;
    double value = 0.0;
  };
  Finding FindDeviation() const;
  Finding FindSettling() const;
  Finding FindExtremes() const;

  const Expectation& expectation_;
  double low_;
  double high_;
  std::optional<Point> least_;  ///< within the time
  std::optional<Point> most_;
  std::optional<Point> first_outside_;
  std::optional<Point> last_outside_;  ///< at any time so far, for kSettles
};

}  // namespace servohil::scenario
