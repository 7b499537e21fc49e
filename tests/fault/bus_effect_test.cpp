// What each fault of the bus and of the emulator decides about frames, wire and machine. That sender,
// receiver and loop do so is in tests/emulator/fault_task_test.cpp, and from outside in
// tests/e2e/test_injected_faults.py.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>

#include "bench.hpp"
#include "effect_tests.hpp"
#include "fault/effects.hpp"

namespace servohil::fault {
namespace {

using testing::Of;

constexpr std::uint8_t kMessage = 2;
constexpr std::uint64_t kFrames = 10'000;

Schedule With(const char* name, const std::vector<double>& values = {}, std::uint64_t seed = 0) {
  Injection injection = testing::Of(name, values);
  injection.start_tick = 1;
  injection.seed = seed;
  Schedule schedule;
  EXPECT_TRUE(schedule.Inject(injection));
  return schedule;
}

Transmission Fate(const Schedule& schedule, std::uint64_t tick = 1, std::uint8_t message = kMessage) {
  return FateOfPublished(schedule, message, tick);
}

/// Of n frames n p are hit, within 4 sqrt(n p (1 - p)); the same ones with the same seed, others with
/// another, and of another message others.
template <typename Hit>
void ExpectShareHit(const char* name, const std::vector<double>& values, double probability, Hit&& hit) {
  const Schedule schedule = With(name, values, 5);
  std::uint64_t count = 0;
  std::uint64_t same_as_other_seed = 0;
  std::uint64_t same_as_other_message = 0;
  for (std::uint64_t tick = 1; tick <= kFrames; ++tick) {
    const bool is_hit = hit(schedule, tick, kMessage);
    EXPECT_EQ(hit(With(name, values, 5), tick, kMessage), is_hit);
    count += is_hit ? 1U : 0U;
    same_as_other_seed += hit(With(name, values, 6), tick, kMessage) == is_hit ? 1U : 0U;
    same_as_other_message += hit(schedule, tick, kMessage + 1) == is_hit ? 1U : 0U;
  }
  const double n = static_cast<double>(kFrames);
  const double bound = 4 * std::sqrt(n * probability * (1 - probability));
  EXPECT_NEAR(static_cast<double>(count), n * probability, bound);
  const double agree = probability * probability + (1 - probability) * (1 - probability);
  EXPECT_NEAR(static_cast<double>(same_as_other_seed), n * agree, 4 * std::sqrt(n * agree * (1 - agree)));
  if (std::get_if<TransmitAct>(&Find(testing::Of(name).id)->act) != nullptr) {
    EXPECT_NEAR(static_cast<double>(same_as_other_message), n * agree,
                4 * std::sqrt(n * agree * (1 - agree)));
  }
}

void Silent() {
  EXPECT_TRUE(Fate(With("tx_silent")).lost);
  Injection one = testing::Of("tx_silent");
  one.target = kMessage;
  Schedule schedule;
  schedule.Inject(one);
  EXPECT_TRUE(Fate(schedule).lost);
  EXPECT_FALSE(Fate(schedule, 1, kMessage + 1).lost) << "another message is not concerned";
}
void Lost() {
  ExpectShareHit("tx_lost", {0.3}, 0.3, [](const Schedule& s, std::uint64_t tick, std::uint8_t message) {
    return Fate(s, tick, message).lost;
  });
}
/// 12.3 ms are 123 ticks.
void DelayedFrames() {
  EXPECT_EQ(Fate(With("tx_delayed", {12.3})).delay_ticks, 123U);
}
/// Uniform from 0 to 10 ms: mean 50 ticks within 4 * 100/sqrt(12 n), all tenths of it alike.
void Jittered() {
  const Schedule schedule = With("tx_jittered", {10.0});
  std::array<int, 10> tenths{};
  double sum = 0.0;
  for (std::uint64_t tick = 1; tick <= kFrames; ++tick) {
    const std::uint32_t delay = Fate(schedule, tick).delay_ticks;
    ASSERT_LE(delay, 100U);
    sum += delay;
    ++tenths[std::min(delay / 10, 9U)];
  }
  EXPECT_NEAR(sum / kFrames, 50.0, 4 * 100 / std::sqrt(12.0 * kFrames));
  for (int count : tenths) EXPECT_NEAR(count, 1'000, 4 * std::sqrt(900.0) + 50) << "rounding widens the last";
}
void Duplicated() {
  EXPECT_EQ(Fate(With("tx_duplicated")).copies, 2);
  ExpectShareHit("tx_duplicated", {0.25}, 0.25,
                 [](const Schedule& s, std::uint64_t tick, std::uint8_t message) {
                   return Fate(s, tick, message).copies == 2;
                 });
}
void Reordered() {
  ExpectShareHit("tx_reordered", {0.5}, 0.5, [](const Schedule& s, std::uint64_t tick, std::uint8_t message) {
    return Fate(s, tick, message).after_next;
  });
}
void CounterStuck() {
  EXPECT_TRUE(Fate(With("counter_stuck")).counter_stuck);
  EXPECT_STREQ(Unsupported(testing::Named("counter_stuck"), {}),
               "no published message has a counter: set e2e in [[can.publish]]");
}
void ChecksumWrong() {
  EXPECT_TRUE(Fate(With("checksum_wrong")).checksum_wrong);
  ExpectShareHit("checksum_wrong", {0.2}, 0.2,
                 [](const Schedule& s, std::uint64_t tick, std::uint8_t message) {
                   return Fate(s, tick, message).checksum_wrong;
                 });
}
/// So many bits of each frame, each bit as often as another, within 4 sigma.
void BitsFlipped() {
  const Schedule schedule = With("bits_flipped", {3.0});
  std::array<int, 64> flips{};
  for (std::uint64_t tick = 1; tick <= kFrames; ++tick) {
    const Transmission fate = Fate(schedule, tick);
    std::array<std::uint8_t, 8> data{};
    FlipBits(data, fate.flipped_bits, fate.flip_key);
    int count = 0;
    for (std::size_t bit = 0; bit < flips.size(); ++bit) {
      const int flipped = data[bit / 8] >> (bit % 8) & 1;
      count += flipped;
      flips[bit] += flipped;
    }
    ASSERT_EQ(count, 3) << "different ones";
  }
  const double p = 3.0 / 64;
  for (int count : flips) EXPECT_NEAR(count, kFrames * p, 4.5 * std::sqrt(kFrames * p * (1 - p)));
  std::array<std::uint8_t, 1> few{};
  FlipBits(few, 64, 1);
  EXPECT_EQ(few[0], 0xFF) << "no more than there are";
}
void Babbling() {
  const Line line = LineAt(With("babbling", {0x7, 250.0}), 1);
  EXPECT_EQ(line.babble_hz, 250.0);
  EXPECT_EQ(line.babble_id, 7U);
  EXPECT_EQ(LineAt(Schedule(), 1).babble_hz, 0.0);
}
void LostOnTheWay() {
  ExpectShareHit("rx_lost", {0.3}, 0.3, [](const Schedule& s, std::uint64_t number, std::uint8_t) {
    return FateOfArrived(s, number, 1).lost;
  });
}
void LateOnTheWay() {
  EXPECT_EQ(FateOfArrived(With("rx_delayed", {20.0}), 1, 1).delay_ticks, 200U);
}
void InterfaceDown() {
  EXPECT_TRUE(LineAt(With("interface_down"), 1).down);
  EXPECT_FALSE(LineAt(With("interface_down"), 0).down) << "not yet";
}
void ErrorFrames() {
  EXPECT_EQ(LineAt(With("error_frames", {40.0}), 1).errors_hz, 40.0);
  EXPECT_STREQ(Unsupported(testing::Named("error_frames"), {.why_no_error_frames = "because"}), "because");
  EXPECT_EQ(Unsupported(testing::Named("error_frames"), {}), nullptr);
}
/// At the start of each pulse.
void MissedTicks() {
  Injection injection = testing::Of("missed_ticks", {30.0});
  injection.start_tick = 10;
  injection.for_ticks = 5;
  injection.period_ticks = 20;
  injection.times = 0;
  Schedule schedule;
  schedule.Inject(injection);
  for (std::uint64_t tick = 1; tick < 60; ++tick)
    EXPECT_EQ(StallAt(schedule, tick).ms, tick == 10 || tick == 30 || tick == 50 ? 30.0 : 0.0) << tick;
  EXPECT_STREQ(Unsupported(testing::Named("missed_ticks"), {.real_time = false}),
               "no tick can be late: this run is not in real time");
}

TEST(BusFaults, ThatAreRampedHitMoreAndMore) {
  Injection injection = testing::Of("tx_lost", {1.0});
  injection.start_tick = 1;
  injection.ramp_ticks = 1'000;
  Schedule schedule;
  schedule.Inject(injection);
  int lost[2] = {};
  for (std::uint64_t tick = 1; tick <= 1'000; ++tick)
    lost[tick > 500 ? 1 : 0] += Fate(schedule, tick).lost ? 1 : 0;
  EXPECT_NEAR(lost[0], 125, 45) << "mean share 1/4";
  EXPECT_NEAR(lost[1], 375, 45) << "mean share 3/4";
}

TEST(BusFaults, AreGoneWhenCleared) {
  for (const Spec& spec : Catalogue()) {
    if (spec.ActsAs<ParameterAct>() || spec.HasSignal()) continue;
    Schedule schedule = With(spec.name, {});
    schedule.ClearAll();
    const Transmission fate = Fate(schedule);
    EXPECT_TRUE(!fate.lost && !fate.after_next && !fate.counter_stuck && !fate.checksum_wrong &&
                fate.copies == 1 && fate.flipped_bits == 0 && fate.delay_ticks == 0)
        << spec.name;
    EXPECT_FALSE(FateOfArrived(schedule, 1, 1).lost);
    EXPECT_EQ(FateOfArrived(schedule, 1, 1).delay_ticks, 0U);
    const Line line = LineAt(schedule, 1);
    EXPECT_TRUE(!line.down && line.babble_hz == 0.0 && line.errors_hz == 0.0) << spec.name;
    EXPECT_EQ(StallAt(schedule, 1).ms, 0.0);
  }
}

}  // namespace

const testing::Effects testing::kBusEffects = {
    {"tx_silent", Silent},
    {"tx_lost", Lost},
    {"tx_delayed", DelayedFrames},
    {"tx_jittered", Jittered},
    {"tx_duplicated", Duplicated},
    {"tx_reordered", Reordered},
    {"counter_stuck", CounterStuck},
    {"checksum_wrong", ChecksumWrong},
    {"bits_flipped", BitsFlipped},
    {"babbling", Babbling},
    {"rx_lost", LostOnTheWay},
    {"rx_delayed", LateOnTheWay},
    {"interface_down", InterfaceDown},
    {"error_frames", ErrorFrames},
    {"missed_ticks", MissedTicks},
};

}  // namespace servohil::fault
