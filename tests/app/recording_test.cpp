#include "servohil/app/recording/recorder.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>

#include "default_setup.hpp"
#include "servohil/app/configuration_text.hpp"
#include "servohil/app/recording/reader.hpp"
#include "servohil/error.hpp"

namespace servohil::app {
namespace {

namespace fs = std::filesystem;

/// A directory for one test.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "servohil-recording-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch directory");
    path_ = name;
  }
  ~Scratch() { fs::remove_all(path_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  fs::path operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

/// Telemetry of any bits, from a generator that starts where the test says.
class RandomTelemetry {
 public:
  explicit RandomTelemetry(unsigned seed) : random_(seed) {}

  double Number() {
    // Any bit pattern but NaN, which is unequal to itself: infinities, subnormals and both zeros too.
    double value = 0.0;
    do {
      value = std::bit_cast<double>(random_());
    } while (std::isnan(value));
    return value;
  }

  Telemetry At(std::uint64_t tick) {
    Telemetry t;
    t.sample.tick = tick;
    t.sample.p1_psi = Number();
    model::State& state = t.sample.state;
    for (double* value :
         {&state.x3_in, &state.v3_in_s, &state.p3_psi, &state.p4_psi, &state.p8_psi, &state.p2_psi})
      *value = Number();
    state.mode.motion = static_cast<model::Motion>(random_() % 6);
    state.mode.plunger = static_cast<model::Plunger>(random_() % 3);
    state.mode.diaphragm_seated = random_() % 2 != 0;
    state.mode.relay_port_full = random_() % 2 != 0;
    t.sample.unresolved_ticks = random_();
    t.sample.model_fault = random_() % 2 != 0;
    t.sample.state_hash = random_();
    t.status.mode = static_cast<Mode>(random_() % 4);
    t.status.timing_valid = random_() % 2 != 0;
    t.status.late_ticks = random_();
    t.status.worst_lateness_ns = static_cast<std::int64_t>(random_());
    t.status.commanded = random_() % 2 != 0;
    t.status.command_age_ticks = random_();
    return t;
  }

 private:
  std::mt19937_64 random_;
};

void ExpectEqual(const Telemetry& a, const Telemetry& b) {
  ASSERT_EQ(a.sample.tick, b.sample.tick);
  EXPECT_EQ(a.sample.p1_psi, b.sample.p1_psi) << "tick " << a.sample.tick;
  EXPECT_EQ(a.sample.state.Vector(), b.sample.state.Vector()) << "tick " << a.sample.tick;
  EXPECT_EQ(a.sample.state.mode.motion, b.sample.state.mode.motion);
  EXPECT_EQ(a.sample.state.mode.plunger, b.sample.state.mode.plunger);
  EXPECT_EQ(a.sample.state.mode.diaphragm_seated, b.sample.state.mode.diaphragm_seated);
  EXPECT_EQ(a.sample.state.mode.relay_port_full, b.sample.state.mode.relay_port_full);
  EXPECT_EQ(a.sample.unresolved_ticks, b.sample.unresolved_ticks);
  EXPECT_EQ(a.sample.model_fault, b.sample.model_fault);
  EXPECT_EQ(a.sample.state_hash, b.sample.state_hash);
  EXPECT_EQ(a.status.mode, b.status.mode);
  EXPECT_EQ(a.status.timing_valid, b.status.timing_valid);
  EXPECT_EQ(a.status.late_ticks, b.status.late_ticks);
  EXPECT_EQ(a.status.worst_lateness_ns, b.status.worst_lateness_ns);
  EXPECT_EQ(a.status.commanded, b.status.commanded);
  EXPECT_EQ(a.status.command_age_ticks, b.status.command_age_ticks);
}

RecordingAttributes Attributes(const testing::DefaultSetup& setup) {
  RecordingAttributes attributes = DescribeConfiguration(setup.configuration);
  attributes.program_version = "1.2.3";
  attributes.clock = "fast";
  attributes.buses = {"vcan0", "slcan0"};
  return attributes;
}

constexpr RecorderOptions kWaiting{.producers_wait = true};
const RecordingEnd kEnd{"VALID", 0x0123'4567'89AB'CDEFU};

TEST(Recording, IsReadBackBitForBit) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  constexpr std::uint64_t kTicks = 50'000;
  constexpr unsigned kSeed = 1;
  {
    Recorder recorder(scratch / "run", Attributes(setup), setup.contract, kWaiting);
    RandomTelemetry random(kSeed);
    for (std::uint64_t tick = 1; tick <= kTicks; ++tick) {
      if (tick % 100 == 0) recorder.RecordCommand(tick, static_cast<double>(tick) / 3.0);
      recorder.RecordTick(random.At(tick));
    }
    const RecordingReport report = recorder.Finish(kEnd);
    EXPECT_TRUE(report.complete) << report.problem;
    EXPECT_EQ(report.samples, kTicks);
    EXPECT_EQ(report.commands, kTicks / 100);
  }

  const RecordingReader reader(scratch / "run");
  EXPECT_TRUE(reader.Complete());
  ASSERT_TRUE(reader.End());
  EXPECT_EQ(reader.End()->verdict, kEnd.verdict);
  EXPECT_EQ(reader.End()->final_state_hash, kEnd.final_state_hash);
  ASSERT_EQ(reader.SampleCount(), kTicks);
  EXPECT_TRUE(reader.Gaps().empty());

  RandomTelemetry random(kSeed);
  std::vector<Telemetry> block(7'001);  // no multiple of a chunk
  std::uint64_t row = 0;
  while (const std::size_t count = reader.ReadSamples(row, block)) {
    for (std::size_t i = 0; i < count; ++i) ExpectEqual(block[i], random.At(++row));
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_EQ(row, kTicks);

  const std::vector<RecordedCommand> commands = reader.Commands();
  ASSERT_EQ(commands.size(), kTicks / 100);
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const std::uint64_t tick = (i + 1) * 100;
    EXPECT_EQ(commands[i], (RecordedCommand{tick, static_cast<double>(tick) / 3.0}));
  }
}

TEST(Recording, HoldsWhatTheRunDependedOnWhateverItsLength) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  RecordingAttributes attributes = Attributes(setup);
  attributes.dbc += "\n" + std::string(1'000'000, '#');  // far beyond the 64 KiB of an object header
  attributes.every_ticks = 10;
  Recorder(scratch / "run", attributes, setup.contract).Finish(kEnd);

  const RecordingReader reader(scratch / "run");
  const RecordingAttributes& read = reader.Attributes();
  EXPECT_EQ(read.configuration_toml, attributes.configuration_toml);
  EXPECT_EQ(read.dbc, attributes.dbc);
  EXPECT_EQ(read.load_csv, attributes.load_csv);
  EXPECT_EQ(read.load_closing_csv, attributes.load_closing_csv);
  EXPECT_EQ(read.program_version, "1.2.3");
  EXPECT_EQ(read.clock, "fast");
  EXPECT_EQ(read.buses, attributes.buses);
  EXPECT_EQ(read.every_ticks, 10U);
  EXPECT_NE(read.host, "");
  EXPECT_EQ(read.start_time.size(), std::strlen("2026-01-01T00:00:00Z"));
}

TEST(Recording, TakesEveryNthTickAndEveryCommand) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  RecordingAttributes attributes = Attributes(setup);
  attributes.every_ticks = 25;
  Recorder recorder(scratch / "run", attributes, setup.contract, kWaiting);
  RandomTelemetry random(2);
  for (std::uint64_t tick = 1; tick <= 1'000; ++tick) {
    recorder.RecordCommand(tick, 30.0);
    recorder.RecordTick(random.At(tick));
  }
  EXPECT_TRUE(recorder.Finish(kEnd).complete);
  const RecordingReader reader(scratch / "run");
  std::vector<Telemetry> samples(100);
  ASSERT_EQ(reader.ReadSamples(0, samples), 40U);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(samples[i].sample.tick, 25 * (i + 1));
  EXPECT_EQ(reader.Commands().size(), 1'000U);
}

}  // namespace
}  // namespace servohil::app
