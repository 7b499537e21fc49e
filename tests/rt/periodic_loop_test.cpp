#include "rt/periodic_loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace servohil::rt {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;

TEST(PeriodicLoop, NeverWakesBeforeItsDeadline) {
  PeriodicLoop loop(kPeriodNs);
  const std::atomic<bool> stop{false};
  const std::int64_t first_ns = base::MonotonicNs() + kPeriodNs;
  std::int64_t deadline_ns = first_ns;
  int left = 50;
  loop.Run(
      stop,
      [&](const LoopTiming&) noexcept {
        EXPECT_GE(base::MonotonicNs(), deadline_ns);
        deadline_ns += kPeriodNs;
        return --left > 0;
      },
      first_ns);
  EXPECT_EQ(loop.Timing().wakes, 50U);
}

TEST(PeriodicLoop, AfterAnOverrunItCatchesUpBackToBackAndKeepsItsPhase) {
  PeriodicLoop loop(kPeriodNs);
  const std::atomic<bool> stop{false};
  const std::int64_t first_ns = base::MonotonicNs() + kPeriodNs;
  std::vector<std::int64_t> begins_ns;
  loop.Run(
      stop,
      [&](const LoopTiming&) noexcept {
        begins_ns.push_back(base::MonotonicNs());
        if (begins_ns.size() == 5) {  // the work of the fifth wake-up takes ten periods
          while (base::MonotonicNs() < first_ns + (4 + 10) * kPeriodNs) {
          }
        }
        return begins_ns.size() < 40;
      },
      first_ns);
  // Wake-ups 6 to 14 (deadlines 5 to 13 periods) begin at period 14 or later: late by one period or more,
  // each.
  EXPECT_GE(loop.Timing().late.Count(), 9U);
  EXPECT_GE(loop.Timing().late.Count(LateCause::kComputedLong) + loop.Timing().late.Count(LateCause::kBoth),
            9U);
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
        late_seen = timing.late.Count();
        return --left > 0;
      },
      base::MonotonicNs() - 1'000 * kPeriodNs);
  EXPECT_EQ(late_seen, 20U) << "the work sees its own wake-up accounted";
}

TEST(PeriodicLoop, AWakeUpThatSleptTooLongWokeLate) {
  PeriodicLoop loop(kPeriodNs);
  const std::atomic<bool> stop{false};
  // No kernel wakes a thread so late on request: begin in the past, where the loop does not sleep at all.
  int left = 3;
  loop.Run(
      stop, [&](const LoopTiming&) noexcept { return --left > 0; }, base::MonotonicNs() - 100 * kPeriodNs);
  EXPECT_EQ(loop.Timing().late.Count(LateCause::kComputedLong), 0U) << "nothing was computed long";
  EXPECT_EQ(loop.Timing().late.Count(LateCause::kWokeLate), 3U);
  ASSERT_EQ(loop.Timing().late.Worst().size(), 1U) << "one overrun";
  EXPECT_EQ(loop.Timing().late.Worst()[0].wake, 1U) << "its worst wake-up";
}

TEST(PeriodicLoop, LatenessInTheGraceIsToldApart) {
  PeriodicLoop loop(kPeriodNs, 5);
  const std::atomic<bool> stop{false};
  int left = 8;
  loop.Run(
      stop, [&](const LoopTiming&) noexcept { return --left > 0; }, base::MonotonicNs() - 100 * kPeriodNs);
  EXPECT_EQ(loop.Timing().late.CountInGrace(), 5U);
  EXPECT_EQ(loop.Timing().late.Count(), 3U);
  EXPECT_LT(loop.Timing().worst_lateness_ns, 96 * kPeriodNs + 50 * kPeriodNs);
}

TEST(LateWakes, KeepsTheWorstOfEachOverrunAndTheWorstOverruns) {
  LateWakes late;
  for (std::int64_t overrun = 1; overrun <= 30; ++overrun) {
    late.Record({.wake = static_cast<std::uint64_t>(overrun), .lateness_ns = overrun * 10});
    late.Record({.wake = static_cast<std::uint64_t>(overrun), .lateness_ns = overrun * 10 - 5});
    late.InTime();
  }
  std::vector<std::int64_t> kept;
  for (const LateWake& one : late.Worst()) kept.push_back(one.lateness_ns);
  std::sort(kept.begin(), kept.end());
  EXPECT_EQ(kept, (std::vector<std::int64_t>{210, 220, 230, 240, 250, 260, 270, 280, 290, 300}));
  EXPECT_EQ(late.Count(), 60U);
}

TEST(PeriodicLoop, StopsWhenAsked) {
  PeriodicLoop loop(kPeriodNs);
  const std::atomic<bool> stop{true};
  loop.Run(stop, [](const LoopTiming&) noexcept { return true; });
  EXPECT_EQ(loop.Timing().wakes, 0U);
}

}  // namespace
}  // namespace servohil::rt
