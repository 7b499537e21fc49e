#pragma once
/// P1 over the time of a scenario.

#include <cstdint>
#include <span>
#include <vector>

#include "scenario/scenario.hpp"

namespace servohil::scenario {

class CommandCourse {
 public:
  /// @param rest_psi  before the first command
  CommandCourse(std::span<const CommandStep> steps, double rest_psi);

  /// P1 during the tick that begins after so many ticks of scenario time: 0 is the first.
  double At(std::uint64_t ticks) const;

 private:
  struct Piece {
    CommandStep step;
    double from_psi;  ///< before it
    double to_psi;    ///< after its ramp, or the middle of its sine
  };
  double rest_psi_;
  std::vector<Piece> pieces_;
};

}  // namespace servohil::scenario
