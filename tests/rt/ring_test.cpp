#include "rt/ring.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace servohil::rt {
namespace {

TEST(Ring, IsFirstInFirstOutAndCountsWhatItDrops) {
  Ring<int, 4> ring;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.TryPush(i));
  EXPECT_FALSE(ring.TryPush(4));
  EXPECT_FALSE(ring.TryPush(5));
  EXPECT_EQ(ring.Dropped(), 2U);
  int item = -1;
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(ring.TryPop(item));
    EXPECT_EQ(item, i);
  }
  EXPECT_FALSE(ring.TryPop(item));
}

TEST(Ring, HoldsForEveryOrderOfPushesAndPops) {
  constexpr int kOperations = 14;
  for (unsigned order = 0; order < (1U << kOperations); ++order) {
    Ring<int, 2> ring;
    int pushed = 0;
    int popped = 0;
    for (int i = 0; i < kOperations; ++i) {
      if ((order >> i & 1U) != 0) {
        const bool room = pushed - popped < 2;
        ASSERT_EQ(ring.TryPush(pushed), room);
        pushed += room ? 1 : 0;
      } else {
        int item = -1;
        ASSERT_EQ(ring.TryPop(item), pushed != popped);
        if (pushed != popped) {
          ASSERT_EQ(item, popped++);
        }
      }
    }
  }
}

TEST(Ring, LosesNothingAcrossThreadsWithoutSayingSo) {
  constexpr std::uint64_t kItems = 500'000;
  Ring<std::uint64_t, 64> ring;
  std::thread producer([&] {
    for (std::uint64_t i = 0; i < kItems; ++i) ring.TryPush(i);
    while (!ring.TryPush(kItems)) std::this_thread::yield();  // the end mark must arrive
  });
  std::uint64_t received = 0;
  std::uint64_t last = 0;
  for (std::uint64_t item = 0; item != kItems;) {
    if (!ring.TryPop(item)) continue;
    if (received != 0) {
      ASSERT_GT(item, last);
    }
    last = item;
    ++received;
  }
  producer.join();
  EXPECT_GE(received + ring.Dropped(), kItems + 1);  // failed tries of the end mark count as drops, too
}

}  // namespace
}  // namespace servohil::rt
