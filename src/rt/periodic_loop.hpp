#pragma once
/// The real-time loop: absolute deadlines t0 + k T for ever, so that neither phase nor simulated time is
/// lost. A wake-up that comes late is followed by the missed ones back to back until the loop has caught up.

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>

#include "base/clock.hpp"
#include "rt/late_wakes.hpp"
#include "rt/latency_histogram.hpp"

namespace servohil::rt {

struct LoopTiming {
  std::uint64_t wakes = 0;
  std::int64_t lateness_ns = 0;        ///< of this wake: start of the work after its deadline
  std::uint64_t behind = 0;            ///< whole periods that this wake began after its deadline
  bool in_grace = false;               ///< this wake is one of the start-up grace
  std::int64_t worst_lateness_ns = 0;  ///< after the grace
  LateWakes late;
  LatencyHistogram
      wake_latency;           ///< of the wakes that slept: what the kernel adds, as cyclictest measures it
  LatencyHistogram lateness;  ///< of every wake, those that catch up included (no coordinated omission)
  LatencyHistogram compute;   ///< of the work of one wake
};

class PeriodicLoop {
 public:
  /// @param period_ns > 0
  /// @param grace_wakes  so many wakes at the start may be late without counting
  explicit PeriodicLoop(std::int64_t period_ns, std::uint64_t grace_wakes = 0) noexcept
      : period_ns_(period_ns), grace_wakes_(grace_wakes) {}

  /// Calls `work(timing)` once a period until it returns false or `stop` is set. First deadline: one period
  /// from now, or `first_deadline_ns`. Real-time safe if `work` is.
  /// @param work  bool work(const LoopTiming&) noexcept: sees this wake already accounted
  template <typename Work>
  void Run(const std::atomic<bool>& stop, Work&& work,
           std::int64_t first_deadline_ns = kOnePeriodFromNow) noexcept {
    std::int64_t deadline_ns =
        first_deadline_ns == kOnePeriodFromNow ? base::MonotonicNs() + period_ns_ : first_deadline_ns;
    std::int64_t end_ns = base::MonotonicNs();
    for (bool go_on = true; go_on && !stop.load(std::memory_order_relaxed); deadline_ns += period_ns_) {
      const bool sleeps = end_ns < deadline_ns;
      if (sleeps) base::SleepUntil(deadline_ns);
      const std::int64_t begin_ns = base::MonotonicNs();
      AccountBegin(begin_ns - deadline_ns, sleeps);
      go_on = work(timing_);
      end_ns = base::MonotonicNs();
      AccountEnd(end_ns - begin_ns);
    }
  }

  /// The loop's thread, or any after Run(); the histograms any time.
  const LoopTiming& Timing() const noexcept { return timing_; }

 private:
  static constexpr std::int64_t kOnePeriodFromNow = std::numeric_limits<std::int64_t>::min();

  void AccountBegin(std::int64_t lateness_ns, bool slept) noexcept {
    ++timing_.wakes;
    timing_.in_grace = timing_.wakes <= grace_wakes_;
    timing_.lateness_ns = lateness_ns;
    timing_.behind = lateness_ns < period_ns_ ? 0 : static_cast<std::uint64_t>(lateness_ns / period_ns_);
    timing_.lateness.Record(lateness_ns);
    if (slept) timing_.wake_latency.Record(lateness_ns);
    if (!timing_.in_grace) timing_.worst_lateness_ns = std::max(timing_.worst_lateness_ns, lateness_ns);
    if (timing_.behind == 0) {
      timing_.late.InTime();
      woke_late_ = false;
      longest_compute_ns_ = 0;
      return;
    }
    // A wake can only be late by a whole period if one slept that long, or one computed that long.
    woke_late_ = woke_late_ || slept;
    const bool computed_long = longest_compute_ns_ >= period_ns_;
    timing_.late.Record({.wake = timing_.wakes,
                         .lateness_ns = lateness_ns,
                         .compute_ns = longest_compute_ns_,
                         .behind = timing_.behind,
                         .cause = !computed_long ? LateCause::kWokeLate
                                  : woke_late_   ? LateCause::kBoth
                                                 : LateCause::kComputedLong,
                         .cpu = sched_getcpu(),
                         .in_grace = timing_.in_grace});
  }

  void AccountEnd(std::int64_t compute_ns) noexcept {
    timing_.compute.Record(compute_ns);
    longest_compute_ns_ = std::max(longest_compute_ns_, compute_ns);
  }

  std::int64_t period_ns_;
  std::uint64_t grace_wakes_;
  LoopTiming timing_;
  bool woke_late_ = false;               ///< since the loop was last in time
  std::int64_t longest_compute_ns_ = 0;  ///< since the loop was last in time
};

}  // namespace servohil::rt
