#include "fault/schedule.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "bench.hpp"

namespace servohil::fault {
namespace {

using testing::Full;
using testing::Of;

Injection Timed(std::uint64_t start, std::uint64_t ramp, std::uint64_t lasts) {
  Injection injection = testing::Of("load_step");
  injection.start_tick = start;
  injection.ramp_ticks = ramp;
  injection.ramp_out_ticks = ramp;
  injection.for_ticks = lasts;
  return injection;
}

/// The parameters have no padding that is written: one is a copy of the other.
bool SameBits(const model::Parameters& a, const model::Parameters& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

TEST(Injection, RisesHoldsAndFalls) {
  const Injection injection = Timed(100, 4, 10);
  EXPECT_EQ(injection.ShareAt(99), 0.0);
  EXPECT_EQ(injection.ShareAt(100), 0.25) << "the first tick has something of it";
  EXPECT_EQ(injection.ShareAt(102), 0.75);
  EXPECT_EQ(injection.ShareAt(103), 1.0);
  EXPECT_EQ(injection.ShareAt(109), 1.0) << "the last of 10";
  EXPECT_EQ(injection.ShareAt(110), 0.75);
  EXPECT_EQ(injection.ShareAt(112), 0.25);
  EXPECT_EQ(injection.ShareAt(113), 0.0);
  EXPECT_FALSE(injection.IsOverAt(113));
  EXPECT_TRUE(injection.IsOverAt(114)) << "10 ticks and the ramp out";
}

TEST(Injection, WithoutARampIsWholeFromItsFirstTickToItsLast) {
  const Injection injection = Timed(100, 0, 3);
  EXPECT_EQ(injection.ShareAt(99), 0.0);
  for (std::uint64_t tick : {100U, 101U, 102U}) EXPECT_EQ(injection.ShareAt(tick), 1.0);
  EXPECT_EQ(injection.ShareAt(103), 0.0);
  EXPECT_TRUE(injection.IsOverAt(103));
}

TEST(Injection, ThatIsShorterThanItsRampFallsFromWhereItCame) {
  const Injection injection = Timed(100, 8, 4);
  EXPECT_EQ(injection.ShareAt(103), 0.5);
  EXPECT_EQ(injection.ShareAt(104), 0.375) << "as steep as it rose";
  EXPECT_EQ(injection.ShareAt(106), 0.125);
  for (std::uint64_t tick = 107; tick < 120; ++tick) EXPECT_EQ(injection.ShareAt(tick), 0.0) << tick;
}

TEST(Injection, WithoutAnEndLastsUntilCleared) {
  const Injection injection = Timed(100, 10, 0);
  EXPECT_EQ(injection.ShareAt(std::uint64_t{1} << 60), 1.0);
  EXPECT_FALSE(injection.IsOverAt(std::uint64_t{1} << 60));
}

TEST(Schedule, ReplacesClearsAndClearsAll) {
  Schedule schedule;
  ASSERT_TRUE(schedule.Inject(testing::Of("load_step", {10.0})));
  ASSERT_TRUE(schedule.Inject(testing::Of("load_step", {30.0})));
  ASSERT_EQ(schedule.size(), 1U) << "one of the same fault is replaced";
  EXPECT_EQ(schedule.begin()->values[0], 30.0);
  ASSERT_TRUE(schedule.Inject(testing::Of("piston_jammed")));
  EXPECT_EQ(schedule.Clear(testing::Named("load_step").id), 1U);
  EXPECT_EQ(schedule.Clear(testing::Named("load_step").id), 0U) << "it is not there any more";
  ASSERT_EQ(schedule.size(), 1U);
  EXPECT_EQ(schedule.begin()->id, testing::Named("piston_jammed").id);
  ASSERT_TRUE(schedule.Inject(testing::Of("cold_oil")));
  EXPECT_EQ(schedule.ClearAll(), 2U);
  EXPECT_EQ(schedule.size(), 0U);
}

TEST(Schedule, IsFullAtItsMostButStillReplaces) {
  Schedule schedule;
  ASSERT_GT(Catalogue().size(), Schedule::kMaxInjections);
  for (std::size_t i = 0; i < Schedule::kMaxInjections; ++i)
    ASSERT_TRUE(schedule.Inject(testing::Of(Catalogue()[i].name)));
  EXPECT_FALSE(schedule.Inject(testing::Of(Catalogue()[Schedule::kMaxInjections].name)));
  EXPECT_EQ(schedule.size(), Schedule::kMaxInjections);
  EXPECT_TRUE(schedule.Inject(testing::Of(Catalogue()[3].name))) << "one that is there already";
  EXPECT_EQ(schedule.size(), Schedule::kMaxInjections);
}

TEST(Schedule, AdvanceTellsExactlyWhenTheParametersMayDiffer) {
  Schedule schedule;
  EXPECT_FALSE(schedule.Advance(1));
  schedule.Inject(Timed(10, 2, 5));
  EXPECT_TRUE(schedule.Advance(2)) << "something was injected";
  std::vector<std::uint64_t> differs;
  for (std::uint64_t tick = 3; tick < 30; ++tick) {
    if (schedule.Advance(tick)) differs.push_back(tick);
  }
  // In: 0.5, 1; out: 0.5, 0; then it is dropped.
  EXPECT_EQ(differs, (std::vector<std::uint64_t>{10, 11, 15, 16, 17}));
  EXPECT_EQ(schedule.size(), 0U);
}

TEST(Schedule, AdvanceTellsEachTickOfAnOscillation) {
  Schedule schedule;
  Injection injection = testing::Of("load_oscillation");
  injection.start_tick = 5;
  injection.for_ticks = 3;
  schedule.Inject(injection);
  schedule.Advance(1);
  for (std::uint64_t tick = 2; tick < 12; ++tick)
    EXPECT_EQ(schedule.Advance(tick), tick >= 5 && tick <= 8) << tick << ": and once more when it is over";
}

TEST(Schedule, WithNothingThatActsTheParametersAreTheUnfaultedOnes) {
  const model::Parameters unfaulted = testing::Full();
  Schedule schedule;
  EXPECT_TRUE(SameBits(schedule.Faulted(unfaulted, 7), unfaulted));
  for (std::size_t i = 0; i < Schedule::kMaxInjections; ++i) {
    Injection injection = testing::Of(Catalogue()[i].name);
    injection.start_tick = 100;
    injection.ramp_ticks = 3;
    injection.ramp_out_ticks = 3;
    injection.for_ticks = 10;
    ASSERT_TRUE(schedule.Inject(injection));
  }
  EXPECT_TRUE(SameBits(schedule.Faulted(unfaulted, 99), unfaulted)) << "they wait";
  EXPECT_FALSE(SameBits(schedule.Faulted(unfaulted, 105), unfaulted)) << "they act";
  EXPECT_TRUE(SameBits(schedule.Faulted(unfaulted, 112), unfaulted)) << "their ramps are down";
  schedule.ClearAll();
  EXPECT_TRUE(SameBits(schedule.Faulted(unfaulted, 105), unfaulted));
}

TEST(Schedule, TheOrderOfInjectionDoesNotMatter) {
  const std::vector<const char*> names = {
      "cold_oil",      "hot_oil",          "plunger_worn",  "plunger_overlapped",
      "supply_loss",   "supply_sag",       "supply_ripple", "drain_back_pressure",
      "piston_jammed", "coulomb_friction", "stiction"};
  Schedule forward;
  Schedule backward;
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (auto [schedule, name] :
         {std::pair{&forward, names[i]}, std::pair{&backward, names[names.size() - 1 - i]}}) {
      Injection injection = testing::Of(name);
      injection.ramp_ticks = 10;
      ASSERT_TRUE(schedule->Inject(injection));
    }
  }
  EXPECT_TRUE(SameBits(forward.Faulted(testing::Full(), 3), backward.Faulted(testing::Full(), 3)));
}

TEST(Schedule, CountsThoseThatAct) {
  Schedule schedule;
  Injection injection = testing::Of("load_step");
  injection.start_tick = 10;
  schedule.Inject(injection);
  schedule.Inject(testing::Of("cold_oil"));
  EXPECT_EQ(schedule.CountActive(9), 1U);
  EXPECT_EQ(schedule.CountActive(10), 2U);
}

}  // namespace
}  // namespace servohil::fault
