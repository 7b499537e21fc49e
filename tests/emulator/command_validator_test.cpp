#include "emulator/command_validator.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "can/dbc/codec.hpp"
#include "support/default_setup.hpp"

namespace servohil::emulator {
namespace {

using V = simulation::FrameVerdict;
constexpr std::int64_t kMs = 1'000'000;

/// Frames of the default DBC: checksum, counter, P1_Demand.
class Bench {
 public:
  explicit Bench(const configuration::SafetySettings& settings = {}) : validator_(settings, 10) {}

  V Take(double p1_psi, std::int64_t time_ms = 0, std::int64_t age_ms = 0) {
    return Take(FrameOf(p1_psi), time_ms, age_ms);
  }
  V Take(const can::Frame& frame, std::int64_t time_ms = 0, std::int64_t age_ms = 0) {
    signal_map::CommandRejection why{};
    const auto demand = setup_.signal_map.Decode(frame, why);
    return validator_.Judge(frame, demand, why, {time_ms * kMs, age_ms * kMs, 0});
  }
  can::Frame FrameOf(double p1_psi) const {
    can::Frame frame;
    frame.id = Message().id;
    frame.size = 4;
    can::Encode(*Message().FindSignal("P1_Demand"), p1_psi, {frame.data.data(), frame.size});
    return frame;
  }
  const can::Message& Message() const { return message_; }
  CommandValidator& Validator() { return validator_; }
  const simulation::Command& Newest() const { return validator_.Newest(); }
  std::uint64_t Count(V verdict) const { return Newest().counts.Of(verdict); }

 private:
  const testing::DefaultSetup setup_;
  const can::Message message_ =
      can::ReadDbc(setup_.configuration.can.dbc.front()).RequireMessage("GOV_Command");
  CommandValidator validator_;
};

TEST(CommandValidator, AFrameOutsideTheConfiguredRangeIsCountedAndNotFollowed) {
  configuration::SafetySettings settings;
  settings.p1_minimum_psi = 20.0;
  settings.p1_maximum_psi = 40.0;
  Bench bench(settings);
  EXPECT_EQ(bench.Take(30.0), V::kValid);
  EXPECT_EQ(bench.Take(19.999), V::kOutOfRange);
  EXPECT_EQ(bench.Take(40.001), V::kOutOfRange);
  EXPECT_EQ(bench.Take(40.0), V::kValid);
  EXPECT_EQ(bench.Newest().p1_psi, 40.0);
  EXPECT_EQ(bench.Count(V::kOutOfRange), 2U);
  EXPECT_EQ(bench.Newest().good, 2U);
  EXPECT_EQ(bench.Newest().good_in_a_row, 1U);
}

TEST(CommandValidator, WhatTheContractRefusesIsCounted) {
  Bench bench;
  can::Frame frame = bench.FrameOf(30.0);
  frame.size = 3;
  EXPECT_EQ(bench.Take(frame), V::kMalformed);
  frame = bench.FrameOf(30.0);
  frame.data[3] = 0xFF;  // more than the 300 psi of the DBC
  EXPECT_EQ(bench.Take(frame), V::kOutOfRange);
  signal_map::Demand not_a_number;
  not_a_number.p1_psi = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(
      bench.Validator().Judge(bench.FrameOf(0.0), not_a_number, signal_map::CommandRejection::kNone, {}),
      V::kOutOfRange);
  EXPECT_EQ(bench.Newest().counts.Rejected(), 3U);
}

TEST(CommandValidator, AChangeFasterThanTheRateIsNotValidOverAtLeastACycle) {
  configuration::SafetySettings settings;
  settings.p1_rate_psi_s = 100.0;  // 1 psi per cycle of 10 ms
  Bench bench(settings);
  EXPECT_EQ(bench.Take(30.0, 0), V::kValid) << "the first has none before it";
  EXPECT_EQ(bench.Take(31.0, 10), V::kValid);
  EXPECT_EQ(bench.Take(32.001, 20), V::kTooFast);
  EXPECT_EQ(bench.Take(33.0, 30), V::kValid) << "20 ms after the last that was valid";
  EXPECT_EQ(bench.Take(32.0, 31), V::kValid) << "two frames close together, as a bus may deliver them";
  EXPECT_EQ(bench.Take(30.9, 41), V::kTooFast);
  EXPECT_EQ(bench.Count(V::kTooFast), 2U);
}

// 300 psi in kPa as a 32-bit float is 300.00001 psi: the limit, not beyond it.
TEST(CommandValidator, ALimitIsReachedWithinTheFramesResolution) {
  configuration::SafetySettings settings;
  settings.p1_minimum_psi = 5.0;
  settings.p1_maximum_psi = 300.0;
  Bench bench(settings);
  const auto judge = [&](double p1_psi, double rounding_psi) {
    signal_map::Demand demand;
    demand.p1_psi = p1_psi;
    demand.p1_rounding_psi = rounding_psi;
    return bench.Validator().Judge(bench.FrameOf(0.0), demand, signal_map::CommandRejection::kNone, {});
  };
  EXPECT_EQ(judge(300.00001, 2e-5), V::kValid);
  EXPECT_EQ(bench.Newest().p1_psi, 300.0);
  EXPECT_EQ(judge(4.99999, 2e-5), V::kValid);
  EXPECT_EQ(bench.Newest().p1_psi, 5.0);
  EXPECT_EQ(judge(300.00003, 2e-5), V::kOutOfRange);
  EXPECT_EQ(judge(300.00001, 0.0), V::kOutOfRange);
  EXPECT_EQ(judge(4.99997, 2e-5), V::kOutOfRange);
}

TEST(CommandValidator, AFrameOlderThanTwentyMillisecondsIsDiscarded) {
  Bench bench;
  EXPECT_EQ(bench.Take(30.0, 0, 20), V::kValid);
  EXPECT_EQ(bench.Take(31.0, 10, 21), V::kStale);
  EXPECT_EQ(bench.Newest().p1_psi, 30.0);
  configuration::SafetySettings settings;
  settings.max_age_ms = 0;
  Bench patient(settings);
  EXPECT_EQ(patient.Take(30.0, 0, 100'000), V::kValid);
}

TEST(CommandValidator, AWrongP1TakesNothingFromATripButATripThatIsNotIntactIsNone) {
  Bench bench;
  signal_map::Demand trip;
  trip.trip = true;
  EXPECT_EQ(bench.Validator().Judge(bench.FrameOf(0.0), trip, signal_map::CommandRejection::kOutOfRange, {}),
            V::kOutOfRange);
  EXPECT_EQ(bench.Newest().trips, 1U);
  EXPECT_EQ(bench.Validator().Judge(bench.FrameOf(0.0), trip, signal_map::CommandRejection::kNone,
                                    {0, 21 * kMs, 0}),
            V::kStale);
  EXPECT_EQ(bench.Newest().trips, 1U);
  EXPECT_EQ(bench.Take(30.0), V::kValid);
  EXPECT_EQ(bench.Newest().good, 0U) << "the trip is still on";
  signal_map::Demand no_trip;
  no_trip.trip = false;
  bench.Validator().TakeCondition(no_trip, {});
  EXPECT_EQ(bench.Take(30.0), V::kValid);
  EXPECT_EQ(bench.Newest().good, 1U);
}

TEST(CommandValidator, NothingIsEnabledBeforeAFrameSaysSoAndEachThatDisablesIsCounted) {
  Bench bench;
  bench.Validator().AwaitEnable();
  EXPECT_EQ(bench.Take(30.0), V::kValid);
  EXPECT_EQ(bench.Newest().good, 0U);
  const auto say = [&](bool enabled) {
    signal_map::Demand demand;
    demand.enabled = enabled;
    bench.Validator().TakeCondition(demand, {});
  };
  say(true);
  EXPECT_EQ(bench.Take(30.0), V::kValid);
  EXPECT_EQ(bench.Newest().good, 1U);
  EXPECT_EQ(bench.Newest().disablings, 0U);
  say(false);
  say(true);
  EXPECT_TRUE(bench.Newest().enabled);
  EXPECT_EQ(bench.Newest().disablings, 1U);
  EXPECT_EQ(bench.Newest().good_in_a_row, 0U) << "the count for recovery begins anew";
}

/// What waited in a queue during an outage is read in one go: the old ones are discarded, but are part of the
/// sequence, so that the first fresh one is the next.
TEST(CommandValidator, NothingThatWaitedDuringAnOutageIsReplayed) {
  Bench bench;
  can::E2eSettings e2e{can::E2eProfile::kCrc8J1850, can::kNoDataId, can::DataIdMode::kBoth,
                       bench.Message().FindSignal("Counter"), bench.Message().FindSignal("Checksum")};
  const can::E2eLayout layout = can::MakeE2eLayout(e2e, bench.Message());
  bench.Validator().Check(layout, 1);
  const auto frame = [&](double p1_psi, unsigned counter) {
    can::Frame protected_frame = bench.FrameOf(p1_psi);
    can::Protect(layout, protected_frame.id, counter, {protected_frame.data.data(), protected_frame.size});
    return protected_frame;
  };
  EXPECT_EQ(bench.Take(frame(30.0, 0)), V::kValid);
  for (unsigned counter = 1; counter < 9; ++counter) {
    EXPECT_EQ(bench.Take(frame(30.0 + counter, counter), 200, 110 - 10 * std::int64_t{counter}), V::kStale);
  }
  EXPECT_EQ(bench.Newest().p1_psi, 30.0);
  EXPECT_EQ(bench.Take(frame(39.0, 9), 200, 5), V::kValid);
  EXPECT_EQ(bench.Newest().counts.lost, 0U);
}

TEST(CommandValidator, TheSequenceIsCheckedBeforeTheValue) {
  Bench bench;
  can::E2eSettings e2e{can::E2eProfile::kCounter, can::kNoDataId, can::DataIdMode::kBoth,
                       bench.Message().FindSignal("Counter"), nullptr};
  const can::E2eLayout layout = can::MakeE2eLayout(e2e, bench.Message());
  bench.Validator().Check(layout, 2);
  const auto take = [&](unsigned counter) {
    can::Frame frame = bench.FrameOf(30.0);
    can::Protect(layout, frame.id, counter, {frame.data.data(), frame.size});
    return bench.Take(frame);
  };
  EXPECT_EQ(take(0), V::kValid);
  EXPECT_EQ(take(0), V::kRepeated);
  EXPECT_EQ(take(0), V::kRepeated);
  EXPECT_EQ(take(0), V::kStuck);
  EXPECT_EQ(take(2), V::kValid) << "one lost, as tolerated";
  EXPECT_EQ(take(1), V::kReordered);
  EXPECT_EQ(take(6), V::kJumped);
  EXPECT_EQ(take(7), V::kValid);
  EXPECT_EQ(bench.Newest().counts.lost, 4U);
  EXPECT_EQ(bench.Newest().counts.OutOfSequence(), 5U);
  EXPECT_EQ(bench.Newest().good, 3U);
}

}  // namespace
}  // namespace servohil::emulator
