#pragma once
/// The loop itself under load: the smallest number of ticks per wake-up at which no tick is late, with a
/// margin.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "configuration/configuration.hpp"
#include "model/parameters.hpp"
#include "model/steady_state.hpp"
#include "rt/process.hpp"

namespace servohil::bench {

/// One number of ticks per wake-up, measured.
struct Level {
  int wake_ticks = 0;
  bool holds = false;  ///< see HoldsWithMargin()
  double measured_s = 0.0;
  std::uint64_t wakes = 0;
  std::uint64_t late_wakes = 0;         ///< began a whole period or more after their deadline
  std::int64_t worst_lateness_ns = 0;   ///< begin of the work after its deadline
  std::uint64_t latency_median_ns = 0;  ///< of the wake-ups that slept
  std::uint64_t latency_p999_ns = 0;
  std::uint64_t compute_median_ns = 0;  ///< of the ticks of one wake-up
  std::uint64_t compute_worst_ns = 0;
};

struct Measurement {
  std::vector<Level> levels;  ///< in the order measured, up to the first that holds
  rt::Shortcomings missing;   ///< real-time properties that could not be had
  std::size_t load_threads = 0;

  /// Ticks per wake-up that hold; nothing when none did.
  std::optional<int> Fit() const {
    if (levels.empty() || !levels.back().holds) return std::nullopt;
    return levels.back().wake_ticks;
  }
};

/// The rule: worst lateness plus worst compute time at most half the wake period. A wake-up twice as bad as
/// the worst one seen would still have been done before the next deadline.
constexpr bool HoldsWithMargin(int wake_ticks, std::int64_t worst_lateness_ns,
                               std::int64_t worst_compute_ns) noexcept {
  constexpr std::int64_t kHalfTickNs = 50'000;
  return worst_lateness_ns + worst_compute_ns <= wake_ticks * kHalfTickNs;
}

/// Measures 1, 2, 5, 10, 20, 50 and the configured number of ticks per wake-up, in rising order, until one
/// holds. Each has half of the time that is left, the last all of it; one that does not hold ends early,
/// after a twelfth of the whole. The loop runs in a thread of its own with the priority and CPU of `loop`, as
/// far as permitted, while a BackgroundLoad disturbs it.
/// @param duration_s  of everything, > 0
Measurement Measure(const model::Parameters& parameters, const model::SteadyState& start,
                    const configuration::LoopSettings& loop, double duration_s);

}  // namespace servohil::bench
