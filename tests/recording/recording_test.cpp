#include "recording/recorder.hpp"
#include "recording/sample_columns.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "base/error.hpp"
#include "configuration/configuration_text.hpp"
#include "recording/reader.hpp"
#include "support/default_setup.hpp"
#include "support/scratch.hpp"

namespace servohil::recording {
namespace {

namespace fs = std::filesystem;
using testing::Scratch;

/// RunState of any bits, from a generator that starts where the test says.
class RandomRunState {
 public:
  explicit RandomRunState(unsigned seed) : random_(seed) {}

  double Number() {
    // Any bit pattern but NaN, which is unequal to itself: infinities, subnormals and both zeros too.
    double value = 0.0;
    do {
      value = std::bit_cast<double>(random_());
    } while (std::isnan(value));
    return value;
  }

  simulation::RunState At(std::uint64_t tick) {
    simulation::RunState t;
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
    t.status.mode = static_cast<simulation::Mode>(random_() % 4);
    t.sample.sub_steps = static_cast<int>(random_() % 49);
    t.status.late = {random_(), random_(), random_(), 0};
    t.status.worst_lateness_ns = static_cast<std::int64_t>(random_());
    t.status.commanded = random_() % 2 != 0;
    t.status.command_age_ticks = random_();
    return t;
  }

 private:
  std::mt19937_64 random_;
};

void ExpectEqual(const simulation::RunState& a, const simulation::RunState& b) {
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
  EXPECT_EQ(a.sample.sub_steps, b.sample.sub_steps);
  EXPECT_EQ(a.status.late.woke_late, b.status.late.woke_late);
  EXPECT_EQ(a.status.late.computed_long, b.status.late.computed_long);
  EXPECT_EQ(a.status.late.both, b.status.late.both);
  EXPECT_EQ(a.status.worst_lateness_ns, b.status.worst_lateness_ns);
  EXPECT_EQ(a.status.commanded, b.status.commanded);
  EXPECT_EQ(a.status.command_age_ticks, b.status.command_age_ticks);
}

RecordingAttributes Attributes(const testing::DefaultSetup& setup) {
  RecordingAttributes attributes;
  static_cast<configuration::RunTexts&>(attributes) =
      configuration::DescribeConfiguration(setup.configuration);
  attributes.program_version = "1.2.3";
  attributes.clock = "fast";
  attributes.buses = {"vcan0", "slcan0"};
  return attributes;
}

/// Values of a column as numbers, straight from HDF5.
std::vector<double> ReadColumn(const fs::path& directory, const char* name) {
  const hid_t file = H5Fopen((directory / kRecordingFile).c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, name, H5P_DEFAULT);
  const hid_t space = H5Dget_space(dataset);
  std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  return values;
}

template <typename Change>
void ChangeFile(const fs::path& name, const Change& change) {
  const hid_t file = H5Fopen(name.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  change(file);
  H5Fclose(file);
}

void FlipBit(const fs::path& name, std::uint64_t place) {
  std::fstream file(name, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(place));
  const int byte = file.get();
  file.seekp(static_cast<std::streamoff>(place));
  file.put(static_cast<char>(byte ^ 0x10));
}

Stimulus CommandAt(std::uint64_t tick, double p1_psi) {
  Stimulus stimulus{.tick = tick};
  stimulus.request.kind = simulation::Request::Kind::kCommand;
  stimulus.request.p1_psi = p1_psi;
  return stimulus;
}

constexpr RecorderOptions kWaiting{.producers_wait = true};
const RecordingEnd kEnd{"VALID", 0x0123'4567'89AB'CDEFU, 60'000};

TEST(Recording, IsReadBackBitForBit) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  constexpr std::uint64_t kTicks = 50'000;
  constexpr unsigned kSeed = 1;
  {
    Recorder recorder(scratch / "run", Attributes(setup), setup.signal_map, kWaiting);
    RandomRunState random(kSeed);
    for (std::uint64_t tick = 1; tick <= kTicks; ++tick) {
      if (tick % 100 == 0) recorder.RecordStimulus(CommandAt(tick, static_cast<double>(tick) / 3.0));
      recorder.RecordTick(random.At(tick));
    }
    const RecordingReport report = recorder.Finish(kEnd);
    EXPECT_TRUE(report.complete) << report.problem;
    EXPECT_EQ(report.samples, kTicks);
    EXPECT_EQ(report.stimuli, kTicks / 100);
  }

  const RecordingReader reader(scratch / "run");
  EXPECT_TRUE(reader.Complete());
  ASSERT_TRUE(reader.End());
  EXPECT_EQ(reader.End()->verdict, kEnd.verdict);
  EXPECT_EQ(reader.End()->final_state_hash, kEnd.final_state_hash);
  EXPECT_EQ(reader.End()->final_tick, kEnd.final_tick);
  ASSERT_EQ(reader.SampleCount(), kTicks);
  EXPECT_TRUE(reader.Gaps().empty());

  RandomRunState random(kSeed);
  std::vector<simulation::RunState> block(7'001);  // no multiple of a chunk
  std::uint64_t row = 0;
  while (const std::size_t count = reader.ReadSamples(row, block)) {
    for (std::size_t i = 0; i < count; ++i) ExpectEqual(block[i], random.At(++row));
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_EQ(row, kTicks);

  const std::vector<Stimulus> commands = reader.Stimuli();
  ASSERT_EQ(commands.size(), kTicks / 100);
  for (std::size_t i = 0; i < commands.size(); ++i) {
    const std::uint64_t tick = (i + 1) * 100;
    EXPECT_EQ(commands[i].tick, tick);
    EXPECT_EQ(commands[i].request.kind, simulation::Request::Kind::kCommand);
    EXPECT_EQ(commands[i].request.p1_psi, static_cast<double>(tick) / 3.0);
  }
}

TEST(Recording, HoldsWhatTheRunDependedOnWhateverItsLength) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  RecordingAttributes attributes = Attributes(setup);
  attributes.dbc.push_back("\n" + std::string(1'000'000, '#'));  // far beyond the 64 KiB of an object header
  attributes.every_ticks = 10;
  Recorder(scratch / "run", attributes, setup.signal_map).Finish(kEnd);

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
  Recorder recorder(scratch / "run", attributes, setup.signal_map, kWaiting);
  RandomRunState random(2);
  for (std::uint64_t tick = 1; tick <= 1'000; ++tick) {
    recorder.RecordStimulus(CommandAt(tick, 30.0));
    recorder.RecordTick(random.At(tick));
  }
  EXPECT_TRUE(recorder.Finish(kEnd).complete);
  const RecordingReader reader(scratch / "run");
  std::vector<simulation::RunState> samples(100);
  ASSERT_EQ(reader.ReadSamples(0, samples), 40U);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(samples[i].sample.tick, 25 * (i + 1));
  EXPECT_EQ(reader.Stimuli().size(), 1'000U);
}

/// What a full ring loses: the file tells exactly which samples.
TEST(Recording, MarksEveryLossAsAGap) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  Recorder recorder(scratch / "run", Attributes(setup), setup.signal_map);
  const simulation::RunState run_state = RandomRunState(3).At(0);
  // Far faster than any disk: the ring fills. A few more, so that there are samples after a gap.
  std::uint64_t tick = 0;
  const auto record = [&] {
    simulation::RunState t = run_state;
    t.sample.tick = ++tick;
    recorder.RecordTick(t);
  };
  while (!recorder.Incomplete()) record();
  for (int i = 0; i < 200'000; ++i) record();
  const RecordingReport report = recorder.Finish(kEnd);
  EXPECT_FALSE(report.complete);
  EXPECT_NE(report.problem.find("too slow"), std::string::npos) << report.problem;
  EXPECT_EQ(report.samples + report.samples_lost, tick);

  const RecordingReader reader(scratch / "run");
  EXPECT_FALSE(reader.Complete());
  ASSERT_EQ(reader.SampleCount(), report.samples);
  std::vector<simulation::RunState> samples(static_cast<std::size_t>(report.samples));
  reader.ReadSamples(0, samples);
  std::vector<RecordingGap> missing;
  std::uint64_t expected = 1;
  const auto expect = [&](std::uint64_t next) {
    if (next != expected) missing.push_back({RecordedStream::kSamples, expected, next - expected});
    expected = next + 1;
  };
  for (const simulation::RunState& sample : samples) expect(sample.sample.tick);
  expect(tick + 1);
  EXPECT_FALSE(missing.empty());
  EXPECT_EQ(reader.Gaps(), missing);
}

std::atomic<std::uint64_t> free_bytes{};

TEST(Recording, EndsBeforeTheDiskIsFull) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  RecorderOptions options = kWaiting;
  options.reserve_bytes = 1'000'000;
  options.free_bytes = [](const fs::path&) { return free_bytes.load(); };
  free_bytes = options.reserve_bytes;
  Recorder recorder(scratch / "run", Attributes(setup), setup.signal_map, options);
  RandomRunState random(4);
  std::uint64_t tick = 0;
  // More than the ring holds, so that some of it is written before the disk is full.
  for (; tick < 50'000; ++tick) recorder.RecordTick(random.At(tick));
  free_bytes = options.reserve_bytes - 1;
  while (!recorder.Incomplete()) recorder.RecordTick(random.At(tick++));
  recorder.RecordStimulus(CommandAt(tick, 30.0));
  recorder.RecordTick(random.At(tick++));
  free_bytes = options.reserve_bytes;  // that there is room again does not make it whole
  const RecordingReport report = recorder.Finish(kEnd);
  EXPECT_FALSE(report.complete);
  EXPECT_NE(report.problem.find("disk full"), std::string::npos) << report.problem;
  EXPECT_GT(report.samples, 0U);
  EXPECT_GT(report.samples_lost, 0U);
  EXPECT_EQ(report.samples + report.samples_lost, tick);
  EXPECT_EQ(report.stimuli_lost, 1U);

  const RecordingReader reader(scratch / "run");  // closed cleanly, and says so
  EXPECT_TRUE(reader.End());
  EXPECT_FALSE(reader.Complete());
  EXPECT_EQ(reader.SampleCount(), report.samples);
  const std::vector<RecordingGap> gaps = reader.Gaps();
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_EQ(gaps[0], (RecordingGap{RecordedStream::kSamples, report.samples, report.samples_lost}));
  EXPECT_EQ(gaps[1].stream, RecordedStream::kStimuli);
}

TEST(Recording, OfAFullDiskDoesNotBegin) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  RecorderOptions options;
  options.free_bytes = [](const fs::path&) { return std::uint64_t{0}; };
  EXPECT_THROW(Recorder(scratch / "run", Attributes(setup), setup.signal_map, options),
               base::EnvironmentError);
}

/// In a process of its own, whose files grow no further than `limit_bytes`: writing beyond fails, as with a
/// quota. @return its report's problem
std::string ProblemOfARecordingLimitedTo(rlim_t limit_bytes, const fs::path& directory, unsigned seed) {
  const testing::DefaultSetup setup;
  std::array<int, 2> channel{};
  if (pipe(channel.data()) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{limit_bytes, limit_bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
    Recorder recorder(directory, Attributes(setup), setup.signal_map, kWaiting);
    RandomRunState random(seed);
    for (std::uint64_t tick = 0; !recorder.Incomplete(); ++tick) recorder.RecordTick(random.At(tick));
    const RecordingReport report = recorder.Finish(kEnd);
    const std::string text = report.complete ? "complete" : report.problem;
    const bool told = write(channel[1], text.data(), text.size()) == static_cast<ssize_t>(text.size());
    _exit(told ? 0 : 1);
  }
  close(channel[1]);
  std::array<char, 1'000> text{};
  const ssize_t size = read(channel[0], text.data(), text.size());
  close(channel[0]);
  int status = -1;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return "the process crashed";
  return {text.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
}

TEST(Recording, SurvivesAWriteErrorWithWhatWasWritten) {
  const Scratch scratch;
  constexpr unsigned kSeed = 5;
  const std::string problem = ProblemOfARecordingLimitedTo(2'000'000, scratch / "run", kSeed);
  EXPECT_NE(problem.find("File too large"), std::string::npos) << problem;
  EXPECT_NE(problem.find("servohil.h5"), std::string::npos) << problem;
  EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;

  const RecordingReader reader(scratch / "run");
  EXPECT_FALSE(reader.Complete());
  EXPECT_GT(reader.SampleCount(), 0U);
  std::vector<simulation::RunState> samples(static_cast<std::size_t>(reader.SampleCount()));
  ASSERT_EQ(reader.ReadSamples(0, samples), samples.size());
  RandomRunState random(kSeed);
  for (std::uint64_t row = 0; row < samples.size(); ++row) ExpectEqual(samples[row], random.At(row));
}

TEST(Recording, IsNotOverwritten) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  Recorder(scratch / "run", Attributes(setup), setup.signal_map).Finish(kEnd);
  try {
    Recorder(scratch / "run", Attributes(setup), setup.signal_map);
    FAIL() << "a second recording went into the same directory";
  } catch (const base::UsageError& error) {
    EXPECT_EQ(std::string(error.what()),
              (scratch / "run").string() +
                  ": holds a recording already (servohil.h5); name a directory without one");
  }
  EXPECT_TRUE(RecordingReader(scratch / "run").Complete());
}

TEST(Recording, HoldsWhatTheFramesCarry) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  Recorder recorder(scratch / "run", Attributes(setup), setup.signal_map);
  // x3 = 4.00007 in goes out as a multiple of 0.0002 in.
  simulation::RunState run_state;
  run_state.sample.tick = 100;
  run_state.sample.state.x3_in = 4.00007;
  run_state.sample.state.v3_in_s = -1.5;
  recorder.RecordSent(100, testing::kPosition, setup.signal_map.Encode(testing::kPosition, run_state));
  recorder.Finish(kEnd);
  EXPECT_EQ(ReadColumn(scratch / "run", "published/SERVO_Position/tick"), std::vector{100.0});
  EXPECT_EQ(ReadColumn(scratch / "run", "published/SERVO_Position/X3"), std::vector{25'000 * 0.0002 - 1.0});
  EXPECT_EQ(ReadColumn(scratch / "run", "published/SERVO_Position/V3"), std::vector{-150 * 0.01});
  EXPECT_EQ(ReadColumn(scratch / "run", "published/SERVO_Position/Tick"), std::vector{100.0});
}

TEST(Recording, LogsEveryFrameInOrderOfTime) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  Recorder recorder(scratch / "run", Attributes(setup), setup.signal_map);
  can::Frame frame{.id = 0x123, .size = 4, .data = {0xDE, 0xAD, 0xBE, 0xEF}};
  frame.receive_time_ns = 1'436'509'052'249'713'999;
  recorder.RecordReceived(frame, 0);
  frame = {.id = 0x1ABCDEF, .extended = true, .size = 0, .receive_time_ns = 1'436'509'052'249'712'000};
  recorder.RecordReceived(frame, 1);
  frame = {.id = 0x7, .remote = true, .size = 5, .receive_time_ns = 1'436'509'053'000'000'000};
  recorder.RecordReceived(frame, 0);
  frame = {.id = 0x7, .fd = true, .bit_rate_switch = true, .size = 1, .data = {0x0F}};
  frame.receive_time_ns = 1'436'509'053'000'001'000;
  recorder.RecordReceived(frame, 0);
  frame.bit_rate_switch = false;
  recorder.RecordReceived(frame, 0);
  EXPECT_EQ(recorder.Finish(kEnd).frames, 5U);

  std::ifstream log(scratch / "run" / "bus.log");
  std::stringstream text;
  text << log.rdbuf();
  EXPECT_EQ(text.str(),
            "(1436509052.249712) slcan0 01ABCDEF#\n"
            "(1436509052.249713) vcan0 123#DEADBEEF\n"
            "(1436509053.000000) vcan0 007#R5\n"
            "(1436509053.000001) vcan0 007##10F\n"
            "(1436509053.000001) vcan0 007##00F\n");
}

TEST(Recording, TakesFromThreeThreadsAtOnce) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  constexpr std::uint64_t kTicks = 100'000;
  constexpr std::uint64_t kFrames = 50'000;
  Recorder recorder(scratch / "run", Attributes(setup), setup.signal_map);
  std::thread simulation([&] {
    simulation::RunState run_state;
    for (std::uint64_t tick = 1; tick <= kTicks; ++tick) {
      if (tick % 10 == 0) recorder.RecordStimulus(CommandAt(tick, 30.0));
      run_state.sample.tick = tick;
      recorder.RecordTick(run_state);
    }
  });
  std::thread receiver([&] {
    const can::Frame frame{.id = 0x100, .size = 4};
    for (std::uint64_t i = 0; i < kFrames; ++i) recorder.RecordReceived(frame, 0);
  });
  std::thread sender([&] {
    const can::Frame frame = setup.signal_map.Encode(testing::kStatus, {});
    for (std::uint64_t i = 0; i < kFrames; ++i) recorder.RecordSent(i, testing::kStatus, frame);
  });
  simulation.join();
  receiver.join();
  sender.join();
  const RecordingReport report = recorder.Finish(kEnd);
  EXPECT_EQ(report.samples + report.samples_lost, kTicks);
  EXPECT_EQ(report.stimuli + report.stimuli_lost, kTicks / 10);
  EXPECT_EQ(report.frames + report.frames_lost, 2 * kFrames);
  EXPECT_EQ(report.complete, report.samples_lost + report.stimuli_lost + report.frames_lost == 0);
  EXPECT_EQ(RecordingReader(scratch / "run").SampleCount(), report.samples);
}

TEST(Recording, AReaderThatLocksTheFileDoesNotDisturbTheWriter) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  Recorder recorder(scratch / "run", Attributes(setup), setup.signal_map, kWaiting);
  const int reader = open((scratch / "run" / kRecordingFile).c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_EQ(flock(reader, LOCK_SH), 0);  // as HDF5 does while it opens
  recorder.RecordTick(RandomRunState(8).At(1));
  const RecordingReport report = recorder.Finish(kEnd);
  close(reader);
  EXPECT_EQ(report.problem, "");
  EXPECT_TRUE(RecordingReader(scratch / "run").Complete());
}

/// Records in a process of its own, which is killed once there is enough on file.
TEST(Recording, OfAKilledProcessIsReadable) {
  const Scratch scratch;
  const testing::DefaultSetup setup;
  const RecordingAttributes attributes = Attributes(setup);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    Recorder recorder(scratch / "run", attributes, setup.signal_map, kWaiting);
    RandomRunState random(6);
    for (std::uint64_t tick = 1;; ++tick) {
      recorder.RecordStimulus(CommandAt(tick, 30.0));
      recorder.RecordTick(random.At(tick));
    }
  }
  std::uint64_t while_written = 0;
  while (while_written < 10'000) {
    ASSERT_EQ(waitpid(child, nullptr, WNOHANG), 0) << "the child lives until it is killed";
    try {
      while_written = RecordingReader(scratch / "run").SampleCount();
    } catch (const base::UsageError&) {
      // Not there yet, or not yet in single-writer mode.
    }
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);

  const RecordingReader reader(scratch / "run");
  EXPECT_FALSE(reader.End());
  EXPECT_FALSE(reader.Complete());
  ASSERT_GE(reader.SampleCount(), while_written);
  std::vector<simulation::RunState> samples(static_cast<std::size_t>(reader.SampleCount()));
  ASSERT_EQ(reader.ReadSamples(0, samples), samples.size());
  RandomRunState random(6);
  for (std::uint64_t i = 0; i < samples.size(); ++i) ExpectEqual(samples[i], random.At(i + 1));
  EXPECT_GE(reader.Stimuli().size(), samples.size()) << "a sample without the command that it used";
}

/// What RecordingReader says to this file.
std::string ErrorOf(const fs::path& path) {
  try {
    const RecordingReader reader(path);
    std::vector<simulation::RunState> samples(static_cast<std::size_t>(reader.SampleCount()));
    reader.ReadSamples(0, samples);
    reader.Stimuli();
  } catch (const base::UsageError& error) {
    return error.what();
  }
  return "no error";
}

class RecordingReaderErrors : public ::testing::Test {
 protected:
  RecordingReaderErrors() {
    Recorder recorder(directory_, Attributes(setup_), setup_.signal_map, kWaiting);
    RandomRunState random(7);
    for (std::uint64_t tick = 1; tick <= 10'000; ++tick) recorder.RecordTick(random.At(tick));
    recorder.Finish(kEnd);
  }

  const Scratch scratch_;
  const testing::DefaultSetup setup_;
  const fs::path directory_ = scratch_ / "run";
  const fs::path file_ = directory_ / kRecordingFile;
};

TEST_F(RecordingReaderErrors, NoneForASoundRecording) {
  EXPECT_EQ(ErrorOf(directory_), "no error");
  EXPECT_EQ(ErrorOf(file_), "no error");
}

TEST_F(RecordingReaderErrors, NoRecording) {
  EXPECT_EQ(ErrorOf(scratch_ / "nothing"), (scratch_ / "nothing").string() + ": there is no such file");
  std::ofstream(scratch_ / "text.h5") << "x3_in,p3_psi\n";
  EXPECT_EQ(ErrorOf(scratch_ / "text.h5"), (scratch_ / "text.h5").string() + ": is no HDF5 file");
}

TEST_F(RecordingReaderErrors, ForeignFile) {
  const fs::path foreign = scratch_ / "foreign.h5";
  H5Fclose(H5Fcreate(foreign.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT));
  EXPECT_EQ(ErrorOf(foreign), foreign.string() + ": is no recording of servohil");
}

TEST_F(RecordingReaderErrors, MissingDataset) {
  ChangeFile(file_, [](hid_t file) { H5Ldelete(file, "samples/p4_psi", H5P_DEFAULT); });
  EXPECT_EQ(ErrorOf(directory_), file_.string() + ": samples/p4_psi: is missing");
}

TEST_F(RecordingReaderErrors, AnOlderRecordingLacksWhatWasAddedLater) {
  ChangeFile(file_, [](hid_t file) {
    for (const char* added : {"samples/safety_cause", "influences/safety_state", "influences/safety_cause"})
      H5Ldelete(file, added, H5P_DEFAULT);
    H5Adelete(file, "servohil_recording");
    const std::uint64_t format_before = 2;
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute =
        H5Acreate2(file, "servohil_recording", H5T_STD_U64LE, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_UINT64, &format_before);
    H5Aclose(attribute);
    H5Sclose(space);
  });
  EXPECT_EQ(ErrorOf(directory_), "no error");
  const RecordingReader reader(directory_);
  std::vector<simulation::RunState> samples(1);
  samples[0].status.safety_cause = simulation::SafetyCause::kNone;
  EXPECT_EQ(reader.ReadSamples(0, samples), 1U);
  EXPECT_EQ(samples[0].status.safety_cause, simulation::SafetyCause::kNone) << "the default";
  std::size_t missing = 0;
  for (std::size_t i = 0; i < SampleColumns().size(); ++i) missing += reader.HasColumn(i) ? 0U : 1U;
  EXPECT_EQ(missing, 1U);
}

TEST_F(RecordingReaderErrors, ShortColumn) {
  ChangeFile(file_, [](hid_t file) {
    const hid_t dataset = H5Dopen2(file, "samples/p4_psi", H5P_DEFAULT);
    const hsize_t rows = 9'000;
    H5Dset_extent(dataset, &rows);
    H5Dclose(dataset);
  });
  EXPECT_EQ(RecordingReader(directory_).SampleCount(), 9'000U);
  EXPECT_EQ(ErrorOf(directory_), "no error");
}

TEST_F(RecordingReaderErrors, AFlippedBitIsLocated) {
  haddr_t address = 0;
  hsize_t size_bytes = 0;
  ChangeFile(file_, [&](hid_t file) {
    const hid_t dataset = H5Dopen2(file, "samples/x3_in", H5P_DEFAULT);
    const hsize_t row = 5'000;  // of the second chunk, 4096 to 8191
    unsigned filters = 0;
    H5Dget_chunk_info_by_coord(dataset, &row, &filters, &address, &size_bytes);
    H5Dclose(dataset);
  });
  ASSERT_GT(size_bytes, 0U);
  FlipBit(file_, address + size_bytes / 2);
  const std::string error = ErrorOf(directory_);
  EXPECT_EQ(error, file_.string() +
                       ": samples/x3_in: rows 4096 to 8191 are damaged: data error detected by "
                       "Fletcher32 checksum");
}

/// Wherever the bit: either an error that names the file, or the same data (a bit that nobody reads).
TEST_F(RecordingReaderErrors, NoFlippedBitGoesUnnoticed) {
  const fs::path copy = scratch_ / "copy.h5";
  std::mt19937_64 random(8);
  const std::uintmax_t size_bytes = fs::file_size(file_);
  int found = 0;
  constexpr int kFlips = 100;
  for (int i = 0; i < kFlips; ++i) {
    fs::copy_file(file_, copy, fs::copy_options::overwrite_existing);
    const std::uint64_t place = random() % size_bytes;
    FlipBit(copy, place);
    const std::string error = ErrorOf(copy);
    if (error != "no error") {
      ++found;
      EXPECT_EQ(error.rfind(copy.string(), 0), 0U) << error;
      EXPECT_EQ(error.find('\n'), std::string::npos) << error;
      continue;
    }
    const RecordingReader reader(copy);
    std::vector<simulation::RunState> samples(static_cast<std::size_t>(reader.SampleCount()));
    reader.ReadSamples(0, samples);
    RandomRunState expected(7);
    for (std::uint64_t row = 0; row < samples.size(); ++row) ExpectEqual(samples[row], expected.At(row + 1));
    ASSERT_FALSE(HasFailure()) << "bit at " << place;
  }
  EXPECT_GT(found, kFlips / 2);  // the samples, which are checked, are most of the file
}

TEST_F(RecordingReaderErrors, TruncatedFile) {
  fs::resize_file(file_, fs::file_size(file_) / 2);
  const std::string error = ErrorOf(directory_);
  EXPECT_EQ(error.rfind(file_.string() + ": ", 0), 0U) << error;
}

}  // namespace
}  // namespace servohil::recording
