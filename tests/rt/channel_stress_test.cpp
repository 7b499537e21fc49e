/// Ring and mailbox between real threads at random speeds: one side far ahead, both in step, both at rest.
/// What ThreadSanitizer looks at; the interleavings themselves are enumerated in interleaving_test.cpp.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <random>
#include <thread>

#include "rt/mailbox.hpp"
#include "rt/ring.hpp"

namespace servohil::rt {
namespace {

/// Wider than any atomic access; all words are the same unless it was torn.
struct WiderThanAtomic {
  std::array<std::uint64_t, 24> words{};

  WiderThanAtomic() = default;
  explicit WiderThanAtomic(std::uint64_t number) { words.fill(number); }
  std::uint64_t Number() const { return words[0]; }
  bool IsTorn() const {
    for (const std::uint64_t word : words) {
      if (word != words[0]) return true;
    }
    return false;
  }
};

/// Changes its mind every few operations about how fast a thread is.
class Pace {
 public:
  explicit Pace(unsigned seed) : random_(seed) {}

  void Wait() {
    if (left_-- == 0) {
      left_ = random_() % 500;
      kind_ = random_() % 4;
    }
    if (kind_ == 1) Spin(random_() % 200);
    if (kind_ == 2 && random_() % 16 == 0) std::this_thread::yield();
    if (kind_ == 3 && random_() % 64 == 0) std::this_thread::sleep_for(std::chrono::microseconds(1));
  }

 private:
  static void Spin(unsigned long turns) {
    for (std::atomic<unsigned long> i{0}; i.load(std::memory_order_relaxed) < turns;)
      i.fetch_add(1, std::memory_order_relaxed);
  }

  std::mt19937 random_;
  unsigned long left_ = 0;
  unsigned long kind_ = 0;
};

constexpr std::uint64_t kItems = 50'000;

class ChannelStress : public ::testing::TestWithParam<unsigned> {};  // seed
INSTANTIATE_TEST_SUITE_P(Seeds, ChannelStress, ::testing::Range(1U, 5U));

TEST_P(ChannelStress, RingAccountsForEveryItem) {
  Ring<WiderThanAtomic, 16> ring;
  std::atomic<bool> done{false};
  std::uint64_t accepted = 0;  // the producer's until it is joined
  std::thread producer([&] {
    Pace pace(GetParam());
    for (std::uint64_t i = 1; i <= kItems; ++i) {
      if (ring.TryPush(WiderThanAtomic(i))) ++accepted;
      pace.Wait();
    }
    done = true;
  });
  Pace pace(GetParam() + 1'000);
  std::uint64_t received = 0;
  std::uint64_t last = 0;
  for (bool last_round = false;;) {
    WiderThanAtomic item;
    if (ring.TryPop(item)) {
      ASSERT_FALSE(item.IsTorn());
      ASSERT_GT(item.Number(), last) << "doubled or out of order";
      last = item.Number();
      ++received;
    } else if (last_round) {
      break;
    } else {
      last_round = done;  // then what is left is popped, and the next empty is the end
    }
    pace.Wait();
  }
  producer.join();
  EXPECT_EQ(received, accepted);
  EXPECT_EQ(received + ring.Dropped(), kItems);
}

TEST_P(ChannelStress, MailboxGivesWholeValuesInOrderAndTheLast) {
  Mailbox<WiderThanAtomic> box;
  std::thread producer([&] {
    Pace pace(GetParam());
    for (std::uint64_t i = 1; i <= kItems; ++i) {
      box.Put(WiderThanAtomic(i));
      pace.Wait();
    }
  });
  Pace pace(GetParam() + 1'000);
  for (std::uint64_t last = 0; last < kItems;) {
    WiderThanAtomic item;
    if (box.Take(item)) {
      ASSERT_FALSE(item.IsTorn());
      ASSERT_GT(item.Number(), last) << "twice, or an older one";
      last = item.Number();
    }
    pace.Wait();
  }
  producer.join();
  WiderThanAtomic item;
  EXPECT_FALSE(box.Take(item)) << "the last was taken";
}

}  // namespace
}  // namespace servohil::rt
