#include "can/progress_watch.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace servohil::can {
namespace {

constexpr std::int64_t kS = 1'000'000'000;
constexpr BusCondition kFull{.faults = 1U << static_cast<unsigned>(BusFault::kQueueFull)};

/// Seconds at which a reset is due, of a bus that is looked at each second.
std::vector<int> Resets(int seconds, const BusCondition& condition, std::uint64_t sent_each_s) {
  ProgressWatch watch;
  std::vector<int> due;
  for (int s = 0; s < seconds; ++s) {
    if (watch.IsResetDue((100 + s) * kS, condition, 7 + static_cast<std::uint64_t>(s) * sent_each_s))
      due.push_back(s);
  }
  return due;
}

TEST(ProgressWatch, ResetsWhatIsStuckThoughTheBusIsWell) {
  // after 5, 10, 20, 40, 60, 60 s
  EXPECT_EQ(Resets(200, kFull, 0), (std::vector<int>{5, 15, 35, 75, 135, 195}));
}

TEST(ProgressWatch, LeavesWhatGoesOnAndWhatHasAReason) {
  EXPECT_EQ(Resets(200, kFull, 1), std::vector<int>{}) << "a slow bus";
  EXPECT_EQ(Resets(200, {}, 0), std::vector<int>{}) << "nothing to send";
  BusCondition alone = kFull;
  alone.state = BusState::kErrorPassive;
  EXPECT_EQ(Resets(200, alone, 0), std::vector<int>{});
}

TEST(ProgressWatch, BeginsAnewOnceFramesGoOut) {
  ProgressWatch watch;
  for (int s = 0; s < 50; ++s) watch.IsResetDue((100 + s) * kS, kFull, 7);
  EXPECT_FALSE(watch.IsResetDue(150 * kS, kFull, 8));
  EXPECT_FALSE(watch.IsResetDue(154 * kS, kFull, 8));
  EXPECT_TRUE(watch.IsResetDue(155 * kS, kFull, 8));
}

}  // namespace
}  // namespace servohil::can
