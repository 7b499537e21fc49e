/// Ring and mailbox, the real templates, in every order in which two threads' accesses can interleave.

#include "interleaving.hpp"

#include <gtest/gtest.h>

#include <set>

#include "rt/mailbox.hpp"
#include "rt/ring.hpp"

namespace servohil::rt {
namespace {

using testing::Exploration;
using testing::Explore;
using testing::Orders;
using testing::SteppedMemory;

/// Its halves are the same number unless it was torn.
struct Item {
  int number = 0;
  int copy = 0;
  bool IsTorn() const { return number != copy; }
};

/// @param orders  what the search found when this was written: a search that ends early is no proof
void ExpectNoFault(const Exploration& exploration, std::uint64_t orders) {
  EXPECT_EQ(exploration.fault, "") << "in the order " << exploration.order;
  EXPECT_EQ(exploration.orders, orders);
}

// --- The explorer
// ----------------------------------------------------------------------------------------------------

/// Two threads of kAccesses each, to one place or to one each.
template <int kAccesses, bool kOnePlace>
struct Counting {
  void RunA() { Count(first); }
  void RunB() { Count(kOnePlace ? first : second); }
  static void Count(SteppedMemory::Atomic<int>& place) {
    for (int i = 0; i < kAccesses; ++i) place.fetch_add(1);
  }
  std::string Fault() { return first.load() + second.load() == 2 * kAccesses ? "" : "lost a count"; }

  SteppedMemory::Atomic<int> first{0};
  SteppedMemory::Atomic<int> second{0};
};

TEST(Explorer, RunsEveryOrderOnce) {
  // 2n choose n.
  ExpectNoFault(testing::Explore<Counting<1, true>>(Orders::kAll), 2);
  ExpectNoFault(testing::Explore<Counting<4, true>>(Orders::kAll), 70);
  ExpectNoFault(testing::Explore<Counting<4, false>>(Orders::kAll), 70);
  ExpectNoFault(testing::Explore<Counting<4, true>>(), 70);
  ExpectNoFault(testing::Explore<Counting<4, false>>(),
                1);  // of accesses to different places all orders are one
}

/// Reads, then writes: what fetch_add is for.
struct RacingCount {
  void RunA() { place.store(place.load() + 1); }
  void RunB() { RunA(); }
  std::string Fault() { return place.load() == 2 ? "" : "lost a count"; }
  SteppedMemory::Atomic<int> place{0};
};

TEST(Explorer, FindsALostUpdate) {
  const Exploration exploration = testing::Explore<RacingCount>();
  EXPECT_EQ(exploration.fault, "lost a count");
  EXPECT_EQ(exploration.order.substr(0, 2), "AB") << "B reads before A has written";
}

// --- Ring
// ------------------------------------------------------------------------------------------------------------

/// The laws of a ring: what was accepted comes out once, whole and in order; a push fails only when full, a
/// pop only when empty; failed pushes are counted.
template <template <typename, std::size_t, typename> typename RingType, std::size_t kCapacity, int kPushes,
          int kPops>
struct RingSystem {
  void RunA() {
    for (int i = 1; i <= kPushes; ++i) {
      const bool has_room = accepted.size() - popped.load() < kCapacity;  // pops only make more
      if (ring.TryPush({i, i})) {
        accepted.push_back(i);
        pushed.store(accepted.size());
      } else {
        ++refused;
        if (has_room) fault = "refused with room";
      }
    }
  }
  void RunB() {
    for (int i = 0; i < kPops; ++i) {
      const bool has_items = received.size() < pushed.load();  // pushes only add more
      if (!Pop() && has_items) fault = "empty with items";
    }
  }
  bool Pop() {
    Item item;
    if (!ring.TryPop(item)) return false;
    if (item.IsTorn()) fault = "torn";
    received.push_back(item.number);
    popped.store(received.size());
    return true;
  }
  std::string Fault() {
    received_by_b = received.size();
    for (int i = 0; i < kPushes && Pop(); ++i) {
    }
    Item item;
    if (fault.empty() && ring.TryPop(item)) fault = "more out than in";
    if (fault.empty() && received != accepted) fault = "lost, doubled or out of order";
    if (fault.empty() && ring.Dropped() != refused) fault = "drops miscounted";
    return fault;
  }
  /// All that the two threads saw.
  std::vector<int> Outcome() const {
    std::vector<int> seen = accepted;
    seen.push_back(static_cast<int>(received_by_b));
    return seen;
  }

  RingType<Item, kCapacity, SteppedMemory> ring;
  SteppedMemory::Atomic<std::size_t> pushed{0};  ///< pushes done, as B may know
  SteppedMemory::Atomic<std::size_t> popped{0};  ///< pops done, as A may know
  std::vector<int> accepted;
  std::vector<int> received;
  std::size_t received_by_b = 0;
  std::uint64_t refused = 0;
  std::string fault;
};

TEST(RingInterleaving, KeepsItsLawsInEveryOrder) {
  ExpectNoFault(testing::Explore<RingSystem<Ring, 1, 2, 2>>(), 23);
  ExpectNoFault(testing::Explore<RingSystem<Ring, 1, 3, 3>>(), 209);
  ExpectNoFault(testing::Explore<RingSystem<Ring, 2, 3, 3>>(), 367);
  ExpectNoFault(testing::Explore<RingSystem<Ring, 2, 4, 4>>(), 4'871);
}

/// What the search leaves out ends in the same states.
template <typename System>
void ExpectSameOutcomes(std::uint64_t all_orders, std::uint64_t distinct_orders, std::size_t outcomes) {
  std::set<std::vector<int>> all;
  std::set<std::vector<int>> distinct;
  ExpectNoFault(Explore<System>(Orders::kAll, [&](const System& s) { all.insert(s.Outcome()); }), all_orders);
  ExpectNoFault(Explore<System>(Orders::kDistinct, [&](const System& s) { distinct.insert(s.Outcome()); }),
                distinct_orders);
  EXPECT_EQ(distinct, all);
  EXPECT_EQ(all.size(), outcomes);
}

TEST(RingInterleaving, DistinctOrdersHaveEveryOutcomeOfAllOrders) {
  ExpectSameOutcomes<RingSystem<Ring, 1, 1, 2>>(1'932, 6, 2);  // B pops the item, or not
  ExpectSameOutcomes<RingSystem<Ring, 1, 2, 1>>(9'584, 7, 3);  // second refused: B pops or not; else B popped
}

/// Announces an item before it is there.
template <typename T, std::size_t kCapacity, typename Memory>
struct HastyRing {
  bool TryPush(const T& item) noexcept {
    const std::size_t tail = tail_.load();
    if (tail - head_.load() == kCapacity) return Drop();
    tail_.store(tail + 1);
    items_[tail % kCapacity] = item;
    return true;
  }
  bool TryPop(T& item) noexcept {
    const std::size_t head = head_.load();
    if (head == tail_.load()) return false;
    item = items_[head % kCapacity];
    head_.store(head + 1);
    return true;
  }
  bool Drop() noexcept {
    ++dropped_;
    return false;
  }
  std::uint64_t Dropped() const noexcept { return dropped_; }

  std::array<typename Memory::template Cell<T>, kCapacity> items_{};
  typename Memory::template Atomic<std::size_t> tail_{0};
  typename Memory::template Atomic<std::size_t> head_{0};
  std::uint64_t dropped_ = 0;  ///< the producer's
};

/// Gives an item's place away before it is read.
template <typename T, std::size_t kCapacity, typename Memory>
struct HastyReader : HastyRing<T, kCapacity, Memory> {
  bool TryPush(const T& item) noexcept {
    const std::size_t tail = this->tail_.load();
    if (tail - this->head_.load() == kCapacity) return this->Drop();
    this->items_[tail % kCapacity] = item;
    this->tail_.store(tail + 1);
    return true;
  }
  bool TryPop(T& item) noexcept {
    const std::size_t head = this->head_.load();
    if (head == this->tail_.load()) return false;
    this->head_.store(head + 1);
    item = this->items_[head % kCapacity];
    return true;
  }
};

TEST(RingInterleaving, FindsSeededFaults) {
  EXPECT_EQ((testing::Explore<RingSystem<HastyRing, 2, 1, 1>>().fault), "torn");
  EXPECT_NE((testing::Explore<RingSystem<HastyReader, 1, 2, 1>>().fault), "");
  EXPECT_EQ((testing::Explore<RingSystem<HastyReader, 1, 1, 1>>().fault), "")
      << "needs a second item to show";
}

// --- Mailbox
// ---------------------------------------------------------------------------------------------------------

/// The laws of a mailbox: what is taken is whole, newer than what was taken before, and at least as new as
/// the last Put() that was done when the Take() began; nothing is taken only when there is nothing new.
template <template <typename, typename> typename MailboxType, int kPuts, int kTakes>
struct MailboxSystem {
  void RunA() {
    for (int i = 1; i <= kPuts; ++i) {
      box.Put({i, i});
      done.store(i);
    }
  }
  void RunB() {
    for (int i = 0; i < kTakes; ++i) Take();
  }
  void Take() {
    const int newest_done = done.load();
    Item item{taken, taken};
    const bool has_taken = box.Take(item);
    if (item.IsTorn()) fault = "torn";
    if (has_taken && item.number <= taken) fault = "taken twice, or older";
    if (item.number < newest_done) fault = "not the newest";
    if (!has_taken && item.number != taken) fault = "changed without being taken";
    taken = item.number;
    outcome.push_back(taken);
  }
  std::vector<int> Outcome() const { return outcome; }
  std::string Fault() {
    Take();
    return fault;
  }

  MailboxType<Item, SteppedMemory> box;
  SteppedMemory::Atomic<int> done{0};  ///< number of the last Put() done, as B may know
  int taken = 0;
  std::vector<int> outcome;  ///< what B had after each Take()
  std::string fault;
};

TEST(MailboxInterleaving, KeepsItsLawsInEveryOrder) {
  ExpectNoFault(testing::Explore<MailboxSystem<Mailbox, 1, 2>>(), 6);
  ExpectNoFault(testing::Explore<MailboxSystem<Mailbox, 2, 2>>(), 25);
  ExpectNoFault(testing::Explore<MailboxSystem<Mailbox, 3, 3>>(), 231);
  ExpectNoFault(testing::Explore<MailboxSystem<Mailbox, 5, 4>>(), 7'738);
}

TEST(MailboxInterleaving, DistinctOrdersHaveEveryOutcomeOfAllOrders) {
  ExpectSameOutcomes<MailboxSystem<Mailbox, 2, 1>>(636, 8, 3);  // B takes nothing, the first or the second
  ExpectSameOutcomes<MailboxSystem<Mailbox, 1, 2>>(130, 6,
                                                   3);  // B takes it at its first try, its second, or not
}

/// Two slots: the producer writes the one that it did not write last, whoever reads it.
template <typename T, typename Memory>
struct TwoSlotMailbox {
  void Put(const T& value) noexcept {
    write_ = 1 - write_;
    slots_[write_] = value;
    newest_.store(write_ + 1);
  }
  bool Take(T& value) noexcept {
    const std::size_t newest = newest_.exchange(0);
    if (newest == 0) return false;
    value = slots_[newest - 1];
    return true;
  }

  std::array<typename Memory::template Cell<T>, 2> slots_{};
  typename Memory::template Atomic<std::size_t> newest_{0};
  std::size_t write_ = 0;
};

/// Three slots, but the exchange in two halves.
template <typename T, typename Memory>
struct SplitExchangeMailbox {
  void Put(const T& value) noexcept {
    slots_[write_] = value;
    const std::size_t old = shared_.load();
    shared_.store(write_ + 4);
    write_ = old % 4;
  }
  bool Take(T& value) noexcept {
    const std::size_t old = shared_.load();
    if (old < 4) return false;
    shared_.store(read_);
    read_ = old % 4;
    value = slots_[read_];
    return true;
  }

  std::array<typename Memory::template Cell<T>, 3> slots_{};
  typename Memory::template Atomic<std::size_t> shared_{1};
  std::size_t write_ = 0;
  std::size_t read_ = 2;
};

TEST(MailboxInterleaving, FindsSeededFaults) {
  EXPECT_NE((testing::Explore<MailboxSystem<TwoSlotMailbox, 3, 1>>().fault), "");
  EXPECT_EQ((testing::Explore<MailboxSystem<TwoSlotMailbox, 1, 1>>().fault), "")
      << "needs more values than slots to show";
  EXPECT_NE((testing::Explore<MailboxSystem<SplitExchangeMailbox, 2, 2>>().fault), "");
}

}  // namespace
}  // namespace servohil::rt
