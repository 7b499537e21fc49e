#pragma once
/// When the sender wakes: at those wake-ups of the loop after which something is due, not at all of them.

#include <algorithm>
#include <array>
#include <cstdint>

#include "simulation/run_state.hpp"

namespace servohil::emulator {

/// The loop's wake-ups count from 1; wake-up k runs the ticks up to first + k * wake_ticks.
class SenderSchedule {
 public:
  /// @param cycle_ticks  of each message; 0: none
  /// @param first_tick   after which the run began
  /// @param most_wakes   at least every so many, > 0: to look for what is not due by cycle
  SenderSchedule(const std::array<std::uint64_t, simulation::kMaxMessages>& cycle_ticks,
                 std::uint64_t wake_ticks, std::uint64_t first_tick, std::uint64_t most_wakes) noexcept
      : cycle_ticks_(cycle_ticks),
        wake_ticks_(wake_ticks),
        first_tick_(first_tick),
        most_wakes_(most_wakes) {}

  /// The next wake-up after `wake` to look at.
  std::uint64_t Next(std::uint64_t wake) const noexcept {
    const std::uint64_t reached = TickOf(wake);
    std::uint64_t next = TickOf(wake + most_wakes_);
    for (const std::uint64_t cycle : cycle_ticks_) {
      if (cycle != 0) next = std::min(next, (reached / cycle + 1) * cycle);
    }
    return (next - first_tick_ + wake_ticks_ - 1) / wake_ticks_;
  }

  /// The newest tick by this wake-up at which something is due; at most the first tick: none yet.
  std::uint64_t NewestDue(std::uint64_t wake) const noexcept {
    const std::uint64_t reached = TickOf(wake);
    std::uint64_t newest = 0;
    for (const std::uint64_t cycle : cycle_ticks_) {
      if (cycle != 0) newest = std::max(newest, reached / cycle * cycle);
    }
    return newest;
  }

 private:
  std::uint64_t TickOf(std::uint64_t wake) const noexcept { return first_tick_ + wake * wake_ticks_; }

  std::array<std::uint64_t, simulation::kMaxMessages> cycle_ticks_;
  std::uint64_t wake_ticks_;
  std::uint64_t first_tick_;
  std::uint64_t most_wakes_;
};

}  // namespace servohil::emulator
