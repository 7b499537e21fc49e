#pragma once
/// Sensors: what they say of the truth, under the faults of a schedule.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "fault/schedule.hpp"

namespace servohil::fault {

/// One thread. Real-time safe throughout.
class Sensors {
 public:
  /// After `tick`: holds what is measured where a fault begins, remembers the truth for those that delay it.
  /// To be called after each tick in which a sensor fault acts.
  void Observe(Schedule& schedule, std::uint64_t tick, std::span<const double> truth) noexcept;

  /// What is measured after `tick`, of each quantity. @pre as many of both; Observe() has been called
  void Measure(const Schedule& schedule, std::uint64_t tick, std::span<const double> truth,
               std::span<double> measured) const noexcept;

  /// A sensor fault acts during `tick`.
  static bool Act(const Schedule& schedule, std::uint64_t tick) noexcept;
  /// One of them remembers what a snapshot does not hold.
  static bool Remember(const Schedule& schedule) noexcept;

 private:
  static constexpr std::size_t kHistoryTicks = 10'001;  ///< 1 s and the present

  /// The truth of one quantity over the last second.
  struct History {
    bool used = false;
    std::uint8_t quantity = 0;
    std::array<double, kHistoryTicks> values{};
  };
  double Apply(const Injection& injection, std::uint64_t tick, double value) const noexcept;
  const History* HistoryOf(std::uint8_t quantity) const noexcept;
  void Note(std::uint8_t quantity, std::uint64_t tick, double truth) noexcept;
  void Forget(const Schedule& schedule) noexcept;

  std::array<History, Schedule::kMaxInjections> histories_{};  ///< one each at most
};

}  // namespace servohil::fault
