#include "servohil/rt/periodic_loop.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace servohil::rt {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;

TEST(PeriodicLoop, NeverWakesBeforeItsDeadline) {
  PeriodicLoop loop(kPeriodNs);
  const std::atomic<bool> stop{false};
  const std::int64_t first_ns = MonotonicNs() + kPeriodNs;
  std::int64_t deadline_ns = first_ns;
  int left = 50;
  loop.Run(
      stop,
      [&](const LoopTiming&) noexcept {
        EXPECT_GE(MonotonicNs(), deadline_ns);
        deadline_ns += kPeriodNs;
        return --left > 0;
      },
      first_ns);
  EXPECT_EQ(loop.Timing().wakes, 50U);
}

TEST(PeriodicLoop, AfterAnOverrunItCatchesUpBackToBackAndKeepsItsPhase) {
  PeriodicLoop loop(kPeriodNs);
  const std::atomic<bool> stop{false};
  const std::int64_t first_ns = MonotonicNs() + kPeriodNs;
  std::vector<std::int64_t> begins_ns;
  loop.Run(
      stop,
      [&](const LoopTiming&) noexcept {
        begins_ns.push_back(MonotonicNs());
        if (begins_ns.size() == 5) {  // the work of the fifth wake-up takes ten periods
          while (MonotonicNs() < first_ns + (4 + 10) * kPeriodNs) {
          }
        }
        return begins_ns.size() < 40;
      },
      first_ns);
  // Wake-ups 6 to 14 (deadlines 5 to 13 periods) begin at period 14 or later: late by one period or more,
  // each.
  EXPECT_GE(loop.Timing().late_wakes, 9U);
  EXPECT_GE(loop.Timing().worst_lateness_ns, 9 * kPeriodNs);
  for (std::size_t i = 0; i < begins_ns.size(); ++i) {
    EXPECT_GE(begins_ns[i], first_ns + static_cast<std::int64_t>(i) * kPeriodNs) << "phase of wake-up " << i;
  }
  EXPECT_EQ(loop.Timing().wakes, 40U) << "none skipped";
}

TEST(PeriodicLoop, StartingInThePastRunsEveryMissedPeriod) {
  PeriodicLoop loop(kPeriodNs);
  const std::atomic<bool> stop{false};
  std::uint64_t late_seen = 0;
  int left = 20;
  loop.Run(
      stop,
      [&](const LoopTiming& timing) noexcept {
        late_seen = timing.late_wakes;
        return --left > 0;
      },
      MonotonicNs() - 1'000 * kPeriodNs);
  EXPECT_EQ(late_seen, 20U) << "the work sees its own wake-up accounted";
}

TEST(PeriodicLoop, StopsWhenAsked) {
  PeriodicLoop loop(kPeriodNs);
  const std::atomic<bool> stop{true};
  loop.Run(stop, [](const LoopTiming&) noexcept { return true; });
  EXPECT_EQ(loop.Timing().wakes, 0U);
}

}  // namespace
}  // namespace servohil::rt
