// A candump log as the governor on the bus: interfaces, time, and what a run would have refused.
#include "run/log_replay.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "configuration/rest.hpp"
#include "support/signal_map_files.hpp"

namespace servohil::run {
namespace {

using V = simulation::FrameVerdict;

const std::string kDbc =
    "BO_ 256 Gov: 8 GOV\n SG_ P1 : 0|16@1+ (0.01,0) [0|300] \"psi\" X\n SG_ On : 16|1@1+ (1,0) [0|1] \"\" X\n SG_ Trip : "
    "17|1@1+ (1,0) [0|1] \"\" X\n SG_ Counter : 52|4@1+ (1,0) [0|15] \"\" X\n SG_ Checksum : 56|8@1+ (1,0) [0|255] \"\" X\n";

signal_map::SignalMap Bind(const std::string& keys) {
  return testing::SignalMapFiles("[can.command]\np1 = \"Gov.P1\"\n" + keys + testing::kNothingPublished,
                                 {kDbc})
      .Bind();
}

LoggedFrame At(int line, std::int64_t time_ms, const std::string& interface = "can0",
               std::uint32_t id = 256) {
  LoggedFrame logged{{}, interface, line};
  logged.frame.id = id;
  logged.frame.size = 8;
  logged.frame.receive_time_ns = time_ms * 1'000'000;
  return logged;
}

template <typename Call>
std::string ErrorOf(Call call) {
  try {
    call();
  } catch (const base::UsageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(LogReplay, TheOnlyInterfaceOfTheGovernorIsTaken) {
  const signal_map::SignalMap signal_map = Bind("");
  const std::vector<LoggedFrame> frames = {At(1, 0, "can0"), At(2, 1, "can1", 0x700), At(3, 2, "can0")};
  EXPECT_EQ(FramesOfInterface(frames, "", signal_map, "x.log").size(), 2U);
  EXPECT_EQ(FramesOfInterface(frames, "can1", signal_map, "x.log").size(), 1U);
  EXPECT_EQ(ErrorOf([&] { FramesOfInterface(frames, "vcan0", signal_map, "x.log"); }),
            "x.log: there is no frame of interface vcan0; there are can0 (2 frames), can1 (1 frames)");
}

TEST(LogReplay, TwoInterfacesWithTheGovernorsMessagesAreRefused) {
  const signal_map::SignalMap signal_map = Bind("");
  const std::vector<LoggedFrame> frames = {At(1, 0, "can0"), At(2, 1, "can1"), At(3, 2, "can0")};
  EXPECT_EQ(
      ErrorOf([&] { FramesOfInterface(frames, "", signal_map, "x.log"); }),
      "x.log: messages of the governor come from several interfaces: can0 (2 frames), can1 (1 frames); choose one "
      "with --interface");
  EXPECT_EQ(FramesOfInterface(frames, "can0", signal_map, "x.log").size(), 2U);
}

TEST(LogReplay, TicksAreThoseOfTheTimeStamps) {
  const std::vector<LoggedFrame> frames = {At(1, 5'000), At(2, 5'010), At(3, 5'005), At(4, 5'020)};
  const std::vector<FrameAfter> line = OnTimeLine(frames, "x.log");
  ASSERT_EQ(line.size(), 4U);
  EXPECT_EQ(line[0].ticks, 0U);
  EXPECT_EQ(line[1].ticks, 100U);
  EXPECT_EQ(line[2].ticks, 100U) << "with the one before it";
  EXPECT_EQ(line[3].ticks, 200U);
}

// Seconds collapsed onto one tick, and the verdict was VALID.
TEST(LogReplay, ATimeStampAheadOrAClockThatWasSetIsNamed) {
  const auto error = [](std::vector<LoggedFrame> frames) {
    return ErrorOf([&] { OnTimeLine(frames, "x.log"); });
  };
  EXPECT_EQ(
      error({At(1, 0), At(2, 6'000), At(3, 10), At(4, 20)}),
      "x.log:3: time steps back by 5.990000 s: a time stamp before it is ahead, or the clock was set; must rise (10 "
      "ms are granted)");
  EXPECT_EQ(
      error({At(1, 1'700'000'000'000), At(2, 10)}).rfind("x.log:2: time steps back by 1699999999.99", 0), 0U);
  EXPECT_EQ(error({At(1, 0), At(7, 3'600'000)}).rfind("x.log:7: time steps ahead by 3600.000000 s", 0), 0U);
  EXPECT_EQ(error({At(1, 100), At(2, 90), At(3, 60'090)}), "no error");
  EXPECT_NE(error({At(1, 100), At(2, 89)}), "no error");
}

/// A log as long as its frames, run with the rules of a configuration.
class Replayed {
 public:
  Replayed(const std::string& keys, const std::vector<FrameAfter>& frames) : signal_map_(Bind(keys)) {
    const configuration::Configuration configuration =
        testing::SignalMapFiles("[can.command]\np1 = \"Gov.P1\"\n" + keys + testing::kNothingPublished,
                                {kDbc})
            .Load();
    const configuration::SafetySettings safety = configuration::Resolved(configuration.safety, 10);
    emulator::TaskOptions options;
    options.duration_ticks = frames.back().ticks + 1;
    options.safety = simulation::LawOf(safety);
    const model::Derived derived(configuration.model);
    task_ = std::make_unique<emulator::SimulationTask>(
        configuration.model, configuration::RequireSteadyStateAt(derived, 4.0), options);
    receiver_ =
        std::make_unique<emulator::Receiver>(signal_map_, emulator::ValidatorOf(signal_map_, safety, 10, 1),
                                             *task_, nullptr, 1, emulator::FrameClock::kSimulated);
    RunLog(*task_, *receiver_, frames, [] { return true; });
  }

  const simulation::RunState& End() const { return task_->Now(); }
  std::uint64_t Count(V verdict) const { return receiver_->Counters().Of(verdict); }
  std::string Text() const { return DescribeReceived(receiver_->Counters()); }
  const signal_map::SignalMap& Frames() const { return signal_map_; }

 private:
  signal_map::SignalMap signal_map_;
  std::unique_ptr<emulator::SimulationTask> task_;
  std::unique_ptr<emulator::Receiver> receiver_;
};

FrameAfter Command(std::uint64_t ticks, double p1_psi, std::uint8_t conditions = 0) {
  FrameAfter after{ticks, At(1, 0).frame};
  const auto raw = static_cast<std::uint16_t>(p1_psi * 100.0 + 0.5);
  after.frame.data[0] = static_cast<std::uint8_t>(raw);
  after.frame.data[1] = static_cast<std::uint8_t>(raw >> 8U);
  after.frame.data[2] = conditions;
  return after;
}

TEST(LogReplay, ACommandIsFelt) {
  const Replayed replayed("", {Command(0, 30.26), Command(100, 31.0), Command(200, 31.0)});
  EXPECT_EQ(replayed.Count(V::kValid), 3U);
  EXPECT_EQ(replayed.End().sample.p1_psi, 31.0);
  EXPECT_EQ(replayed.Text(), "3 commands followed");
}

TEST(LogReplay, WhatARunRefusesIsRefused) {
  const Replayed wrong_checksum("e2e = \"crc8_j1850\"\ncounter = \"Counter\"\nchecksum = \"Checksum\"\n",
                                {Command(0, 30.26), Command(100, 31.0)});
  EXPECT_EQ(wrong_checksum.Count(V::kValid), 0U);
  EXPECT_EQ(wrong_checksum.Count(V::kCorrupted), 2U);
  EXPECT_EQ(wrong_checksum.Text(), "0 commands followed; refused: 2 corrupted");
  const Replayed beyond("", {Command(0, 30.26), Command(100, 301.0)});
  EXPECT_EQ(beyond.Count(V::kOutOfRange), 1U);
  EXPECT_EQ(beyond.End().sample.p1_psi, 30.26);
  FrameAfter too_short = Command(100, 31.0);
  too_short.frame.size = 4;
  EXPECT_EQ(Replayed("", {Command(0, 30.26), too_short}).Count(V::kMalformed), 1U);
}

TEST(LogReplay, TripAndEnableCount) {
  constexpr std::uint8_t kOn = 1;
  constexpr std::uint8_t kTrip = 2;
  const std::string keys = "enable = \"Gov.On\"\ntrip = \"Gov.Trip\"\n";
  const Replayed tripped(
      keys, {Command(0, 30.26, kOn), Command(100, 30.26, kOn | kTrip), Command(200, 30.26, kOn)});
  EXPECT_EQ(tripped.End().status.trips, 1U);
  const Replayed never_enabled(keys, {Command(0, 31.0), Command(100, 31.0)});
  EXPECT_EQ(never_enabled.End().status.safety, simulation::SafetyState::kWaiting);
}

TEST(LogReplay, SilenceIsThatOfTheLog) {
  const Replayed replayed("", {Command(0, 31.0), Command(100, 31.0), Command(5'000, 31.0)});
  EXPECT_EQ(replayed.End().status.losses, 1U);
}

}  // namespace
}  // namespace servohil::run
