#pragma once
/// The real-time loop: absolute deadlines t0 + k T for ever, so that neither phase nor simulated time is
/// lost. A wake-up that comes late is followed by the missed ones back to back until the loop has caught up.

#include <atomic>
#include <cstdint>
#include <limits>

#include "servohil/rt/clock.hpp"
#include "servohil/rt/latency_histogram.hpp"

namespace servohil::rt {

struct LoopTiming {
  std::uint64_t wakes = 0;
  std::uint64_t late_wakes = 0;        ///< began a whole period or more after their deadline
  std::int64_t worst_lateness_ns = 0;  ///< start of the work after its deadline
  LatencyHistogram
      wake_latency;           ///< of the wakes that slept: what the kernel adds, as cyclictest measures it
  LatencyHistogram lateness;  ///< of every wake, those that catch up included (no coordinated omission)
  LatencyHistogram compute;   ///< of the work of one wake
};

class PeriodicLoop {
 public:
  /// @param period_ns > 0
  explicit PeriodicLoop(std::int64_t period_ns) noexcept : period_ns_(period_ns) {}

  /// Calls `work(timing)` once a period until it returns false or `stop` is set. First deadline: one period
  /// from now, or `first_deadline_ns`. Real-time safe if `work` is.
  /// @param work  bool work(const LoopTiming&) noexcept: sees this wake already accounted
  template <typename Work>
  void Run(const std::atomic<bool>& stop, Work&& work,
           std::int64_t first_deadline_ns = kOnePeriodFromNow) noexcept {
    std::int64_t deadline_ns =
        first_deadline_ns == kOnePeriodFromNow ? MonotonicNs() + period_ns_ : first_deadline_ns;
    std::int64_t end_ns = MonotonicNs();
    for (bool go_on = true; go_on && !stop.load(std::memory_order_relaxed); deadline_ns += period_ns_) {
      const bool sleeps = end_ns < deadline_ns;
      if (sleeps) SleepUntil(deadline_ns);
      const std::int64_t begin_ns = MonotonicNs();
      Account(begin_ns - deadline_ns, sleeps);
      go_on = work(timing_);
      end_ns = MonotonicNs();
      timing_.compute.Record(end_ns - begin_ns);
    }
  }

  /// The loop's thread, or any after Run().
  const LoopTiming& Timing() const noexcept { return timing_; }

 private:
  static constexpr std::int64_t kOnePeriodFromNow = std::numeric_limits<std::int64_t>::min();

  void Account(std::int64_t lateness_ns, bool slept) noexcept {
    ++timing_.wakes;
    if (slept) timing_.wake_latency.Record(lateness_ns);
    timing_.lateness.Record(lateness_ns);
    if (lateness_ns >= period_ns_) ++timing_.late_wakes;
    if (lateness_ns > timing_.worst_lateness_ns) timing_.worst_lateness_ns = lateness_ns;
  }

  std::int64_t period_ns_;
  LoopTiming timing_;
};

}  // namespace servohil::rt
