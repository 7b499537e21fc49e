#include "scenario/command_course.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/ticks.hpp"

namespace servohil::scenario {

CommandCourse::CommandCourse(std::span<const CommandStep> steps, double rest_psi) : rest_psi_(rest_psi) {
  for (const CommandStep& step : steps) {
    const double before_psi = At(step.at_tick);
    // A sine goes on from the middle of the one before it.
    const double base_psi = pieces_.empty() ? rest_psi_ : pieces_.back().to_psi;
    pieces_.push_back({step, before_psi, step.is_change ? base_psi + step.p1_psi : step.p1_psi});
  }
}

double CommandCourse::At(std::uint64_t ticks) const {
  const auto next = std::find_if(pieces_.begin(), pieces_.end(),
                                 [&](const Piece& piece) { return piece.step.at_tick > ticks; });
  if (next == pieces_.begin()) return rest_psi_;
  const Piece& piece = *(next - 1);
  const std::uint64_t since = ticks - piece.step.at_tick;
  if (since < piece.step.ramp_ticks) {
    const double share = static_cast<double>(since + 1) / static_cast<double>(piece.step.ramp_ticks);
    return piece.from_psi + share * (piece.to_psi - piece.from_psi);
  }
  const double turns = piece.step.frequency_hz * model::SecondsOf(since);
  return piece.to_psi + piece.step.amplitude_psi * std::sin(2.0 * std::numbers::pi * turns);
}

}  // namespace servohil::scenario
