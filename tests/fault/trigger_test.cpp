// What starts a fault, how often, and what is told of it. Each test writes down the ticks in which it acts.

#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "bench.hpp"
#include "fault/schedule.hpp"

namespace servohil::fault {
namespace {

using testing::Of;
using Ticks = std::vector<std::uint64_t>;

Injection Triggered(Trigger trigger, std::uint64_t for_ticks, std::uint32_t times = 1) {
  Injection injection = testing::Of("load_step");
  injection.trigger = trigger;
  injection.waits = true;
  injection.for_ticks = for_ticks;
  injection.times = times;
  return injection;
}

Trigger Above(double threshold) {
  return {.kind = Trigger::Kind::kCondition, .quantity = 0, .above = true, .threshold = threshold};
}

/// Ticks 1 to `last` in which the first fault acts; `truth(tick)` of quantity 0 after each, `before(tick)` is
/// done before each.
Ticks Acting(
    Schedule& schedule, std::uint64_t last, const std::function<double(std::uint64_t)>& truth,
    const std::function<void(std::uint64_t)>& before = [](std::uint64_t) {}) {
  Ticks acting;
  for (std::uint64_t tick = 1; tick <= last; ++tick) {
    before(tick);
    schedule.Advance(tick);
    if (schedule.size() > 0 && schedule.begin()->ShareAt(tick) > 0.0) acting.push_back(tick);
    const std::array values = {truth(tick)};
    schedule.Observe(tick, values);
  }
  return acting;
}

double Square(std::uint64_t tick) {  // 1 in ticks 10 to 14, 20 to 24, ...
  return tick >= 10 && tick % 10 < 5 ? 1.0 : 0.0;
}

TEST(Triggers, ACondititionStartsItWithTheNextTickOnce) {
  Schedule schedule;
  schedule.Inject(Triggered(Above(0.5), 3));
  EXPECT_EQ(Acting(schedule, 40, Square), (Ticks{11, 12, 13}));
  EXPECT_EQ(schedule.size(), 0U);
}

TEST(Triggers, AConditionThatHoldsAlreadyStartsItAtOnce) {
  Schedule schedule;
  schedule.Inject(Triggered(Above(-1.0), 2));
  EXPECT_EQ(Acting(schedule, 10, Square), (Ticks{2, 3}));
}

TEST(Triggers, BelowAThreshold) {
  Trigger trigger = Above(0.5);
  trigger.above = false;
  Schedule schedule;
  schedule.Inject(Triggered(trigger, 1, 0));
  EXPECT_EQ(Acting(schedule, 30, Square), (Ticks{2, 16, 26})) << "each time that it comes true again";
}

TEST(Triggers, NTimes) {
  Schedule schedule;
  schedule.Inject(Triggered(Above(0.5), 2, 3));
  EXPECT_EQ(Acting(schedule, 100, Square), (Ticks{11, 12, 21, 22, 31, 32}));
  EXPECT_EQ(schedule.size(), 0U);
}

TEST(Triggers, AConditionThatStaysTrueDoesNotFireAgain) {
  Schedule schedule;
  schedule.Inject(Triggered(Above(0.5), 2, 0));
  EXPECT_EQ(Acting(schedule, 100, [](std::uint64_t tick) { return tick >= 5 ? 1.0 : 0.0; }), (Ticks{6, 7}));
  EXPECT_EQ(schedule.size(), 1U) << "it waits for ever";
}

TEST(Triggers, NoFiringBeforeItsTime) {
  Injection injection = Triggered(Above(0.5), 2);
  injection.start_tick = 14;
  Schedule schedule;
  schedule.Inject(injection);
  EXPECT_EQ(Acting(schedule, 100, Square), (Ticks{14, 15})) << "true at 10 already, asked from 13 on";
}

TEST(Triggers, AnotherFaultsStart) {
  Injection injection =
      Triggered({.kind = Trigger::Kind::kFault, .fault = testing::Of("stabilizer_isolated").id}, 2);
  Injection other = testing::Of("stabilizer_isolated");
  other.start_tick = 7;
  other.for_ticks = 1;
  Schedule schedule;
  schedule.Inject(other);
  schedule.Inject(injection);
  EXPECT_EQ(Acting(schedule, 20, Square), (Ticks{8, 9})) << "with the tick after";
}

TEST(Triggers, AFrame) {
  Schedule schedule;
  schedule.Inject(Triggered({.kind = Trigger::Kind::kFrame, .frame_id = 0x123}, 2));
  EXPECT_TRUE(schedule.WaitsForFrame(0x123, false));
  EXPECT_FALSE(schedule.WaitsForFrame(0x123, true));
  EXPECT_EQ(Acting(schedule, 20, Square,
                   [&](std::uint64_t tick) {
                     schedule.TakeFrame(tick == 5 ? 0x124 : 0x100, false, tick);
                     if (tick >= 9) schedule.TakeFrame(0x123, false, tick);
                   }),
            (Ticks{9, 10}))
      << "the first, and the others not";
  EXPECT_FALSE(schedule.WaitsForFrame(0x123, false));
}

TEST(Triggers, PeriodAndDuty) {
  Injection injection = testing::Of("load_step");
  injection.start_tick = 5;
  injection.for_ticks = 2;
  injection.period_ticks = 10;
  injection.times = 3;
  Schedule schedule;
  schedule.Inject(injection);
  EXPECT_EQ(Acting(schedule, 100, Square), (Ticks{5, 6, 15, 16, 25, 26}));
  EXPECT_EQ(schedule.size(), 0U);
  injection.times = 0;
  schedule.Inject(injection);
  EXPECT_EQ(Acting(schedule, 1'000, Square).size(), 200U) << "without end";
}

TEST(Triggers, AConditionStartsARowOfPulses) {
  Injection injection = Triggered(Above(0.5), 1, 3);
  injection.period_ticks = 4;
  Schedule schedule;
  schedule.Inject(injection);
  EXPECT_EQ(Acting(schedule, 100, Square), (Ticks{11, 15, 19}));
  EXPECT_EQ(schedule.size(), 0U);
}

TEST(Triggers, EachPulseHasItsRamps) {
  Injection injection = testing::Of("load_step");
  injection.start_tick = 1;
  injection.ramp_ticks = 2;
  injection.for_ticks = 3;
  injection.ramp_out_ticks = 4;
  injection.period_ticks = 10;
  injection.times = 0;
  for (std::uint64_t pulse = 0; pulse < 3; ++pulse) {
    const double expected[10] = {0.5, 1.0, 1.0, 0.75, 0.5, 0.25, 0.0, 0.0, 0.0, 0.0};
    for (std::uint64_t i = 0; i < 10; ++i)
      EXPECT_EQ(injection.ShareAt(1 + 10 * pulse + i), expected[i]) << pulse << " " << i;
    EXPECT_TRUE(injection.StartsAt(1 + 10 * pulse));
    EXPECT_FALSE(injection.StartsAt(2 + 10 * pulse));
  }
}

struct Told {
  std::uint64_t tick;
  Event::Kind kind;
  std::uint32_t pulse;
  friend bool operator==(const Told&, const Told&) = default;
};

TEST(Events, TellEachStartAndEndWithItsTick) {
  Injection injection = Triggered(Above(0.5), 2, 2);
  injection.ramp_out_ticks = 2;
  Schedule schedule;
  std::vector<Told> told;
  const auto collect = [&] {
    for (const Event& event : schedule.Events()) told.push_back({event.tick, event.kind, event.pulse});
    schedule.ForgetEvents();
  };
  schedule.Inject(injection, 1);
  Acting(schedule, 30, Square, [&](std::uint64_t) { collect(); });
  collect();
  using Kind = Event::Kind;
  EXPECT_EQ(told, (std::vector<Told>{{1, Kind::kWaits, 0},
                                     {11, Kind::kStarts, 0},
                                     {14, Kind::kEnds, 0},
                                     {21, Kind::kStarts, 1},
                                     {24, Kind::kEnds, 1}}));
}

TEST(Events, TellChangesAndClears) {
  Schedule schedule;
  Injection injection = testing::Of("load_step");
  injection.start_tick = 5;
  schedule.Inject(injection, 5);
  schedule.Advance(5);
  schedule.Inject(injection, 6);
  schedule.Inject(testing::Of("cold_oil"), 6);
  schedule.Clear(injection.id, Injection::kEverything, 7);
  schedule.ClearAll(8);
  std::vector<Told> told;
  for (const Event& event : schedule.Events()) told.push_back({event.tick, event.kind, event.id});
  using Kind = Event::Kind;
  const std::uint32_t load_step = injection.id;
  EXPECT_EQ(told, (std::vector<Told>{{5, Kind::kStarts, load_step},
                                     {6, Kind::kChanged, load_step},
                                     {7, Kind::kCleared, load_step},
                                     {8, Kind::kCleared, testing::Of("cold_oil").id}}));
}

}  // namespace
}  // namespace servohil::fault
