#include "rt/mailbox.hpp"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace servohil::rt {
namespace {

TEST(Mailbox, GivesTheNewestOnceAndOnlyOnce) {
  Mailbox<int> box;
  int value = -1;
  EXPECT_FALSE(box.Take(value));
  EXPECT_EQ(value, -1);
  box.Put(1);
  box.Put(2);
  EXPECT_TRUE(box.Take(value));
  EXPECT_EQ(value, 2);
  EXPECT_FALSE(box.Take(value)) << "taken already";
}

/// Every order of n puts and takes, single-threaded: the law holds for each prefix.
TEST(Mailbox, HoldsForEveryOrderOfPutsAndTakes) {
  constexpr int kOperations = 12;
  for (unsigned order = 0; order < (1U << kOperations); ++order) {
    Mailbox<int> box;
    int newest = 0;
    int taken = 0;
    for (int i = 0; i < kOperations; ++i) {
      if ((order >> i & 1U) != 0) {
        box.Put(++newest);
      } else {
        int value = taken;
        ASSERT_EQ(box.Take(value), newest != taken);
        ASSERT_EQ(value, newest);
        taken = newest;
      }
    }
  }
}

TEST(Mailbox, NeverTearsNorGoesBackAcrossThreads) {
  struct Wide {
    std::array<int, 32> words;  // wider than any atomic access
  };
  constexpr int kLast = 200'000;
  Mailbox<Wide> box;
  std::thread producer([&] {
    for (int i = 1; i <= kLast; ++i) {
      Wide wide{};
      wide.words.fill(i);
      box.Put(wide);
    }
  });
  int seen = 0;
  while (seen < kLast) {
    Wide wide{};
    if (!box.Take(wide)) continue;
    for (const int word : wide.words) ASSERT_EQ(word, wide.words[0]) << "torn";
    ASSERT_GT(wide.words[0], seen) << "went back";
    seen = wide.words[0];
  }
  producer.join();
}

}  // namespace
}  // namespace servohil::rt
