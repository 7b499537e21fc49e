#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "configuration/run_texts.hpp"
#include "recording/reader.hpp"
#include "recording/recorder.hpp"
#include "run/scripted_run.hpp"
#include "support/default_setup.hpp"

namespace servohil::emulator {
namespace {

/// Of one process: gone at its end.
class Directory {
 public:
  Directory() {
    std::string name = (std::filesystem::temp_directory_path() / "servohil-safety-XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~Directory() { std::filesystem::remove_all(path_); }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;
  std::filesystem::path File() const { return path_ / "recording"; }

 private:
  std::filesystem::path path_;
};

TaskOptions SupervisedOptions(const testing::DefaultSetup& setup) {
  TaskOptions options = setup.Options();
  options.safety = simulation::LawOf(
      configuration::Resolved(setup.configuration.safety, setup.signal_map.CommandCycleMs()));
  return options;
}

/// A governor that runs, falls silent, comes back, trips, and an operator; the emulator late in between.
/// @return the changes
std::vector<simulation::SafetyChange> RunEventfully(SimulationTask& task, double rest_psi) {
  testing::Governor governor(task);
  rt::LoopTiming timing;
  const auto for_cycles = [&](int cycles, double p1_psi) {
    for (int cycle = 0; cycle < cycles; ++cycle) {
      governor.Send(p1_psi + 0.01 * cycle);
      for (int wake = 0; wake < 10; ++wake) task.Wake(timing);
    }
  };
  const auto silent = [&](int wakes) {
    for (int wake = 0; wake < wakes; ++wake) task.Wake(timing);
  };
  silent(7);
  for_cycles(10, rest_psi + 1.0);
  for (timing.behind = 200; timing.behind > 0; --timing.behind) task.Wake(timing);  // late for 0.2 s: no loss
  for_cycles(3, rest_psi + 0.5);
  silent(100);
  for_cycles(6, rest_psi);
  simulation::Request local;
  local.kind = simulation::Request::Kind::kCommand;
  local.p1_psi = rest_psi + 2.0;
  task.PutRequest(local);
  silent(200);
  for_cycles(2, rest_psi - 1.0);
  silent(50);
  std::vector<simulation::SafetyChange> changes;
  simulation::SafetyChange change;
  while (task.TryPopSafetyChange(change)) changes.push_back(change);
  return changes;
}

TEST(SupervisedRun, ChangesAtTheTicksThatTheCommandsMean) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.configuration.model, setup.start, SupervisedOptions(setup));
  const std::vector<simulation::SafetyChange> changes = RunEventfully(task, setup.start.p1_psi);
  using S = simulation::SafetyState;
  using Cause = simulation::SafetyCause;
  struct Expected {
    std::uint64_t tick;
    S to;
    Cause cause;
  };
  // 70 waiting, 1000 governed, 2000 caught up, 300 governed; its last frame is used at tick 3271.
  const std::vector<Expected> expected = {
      {71, S::kRunning, Cause::kCommand},
      {3'271 + 300, S::kDegraded, Cause::kSilence},
      {4'370 + 201, S::kRunning, Cause::kRecovered},  // with the third frame
      {4'370 + 600 + 2'000 + 200 - 99 + 300, S::kDegraded, Cause::kSilence},
  };
  ASSERT_EQ(changes.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(changes[i].tick, expected[i].tick) << i;
    EXPECT_EQ(changes[i].to, expected[i].to) << i;
    EXPECT_EQ(changes[i].cause, expected[i].cause) << i;
  }
}

/// The replay gets the decisions, whatever it would decide: also without any time-out.
TEST(SupervisedRun, IsReplayedBitForBitWithTheSameChanges) {
  for (const char* on_loss : {"drain", "hold", "freeze"}) {
    const testing::DefaultSetup setup({std::string("safety.on_loss=") + on_loss, "friction.coulomb_psi=2"});
    const Directory directory;
    recording::RecordingAttributes attributes;
    static_cast<configuration::RunTexts&>(attributes) =
        configuration::DescribeConfiguration(setup.configuration);
    recording::RecorderOptions recorder_options;
    recorder_options.producers_wait = true;
    recording::Recorder recorder(directory.File(), attributes, setup.signal_map, recorder_options);
    TaskOptions options = SupervisedOptions(setup);
    options.recorder = &recorder;
    auto task = std::make_unique<SimulationTask>(setup.configuration.model, setup.start, options);
    const std::vector<simulation::SafetyChange> changes = RunEventfully(*task, setup.start.p1_psi);
    const simulation::RunState end = task->Now();
    EXPECT_TRUE(recorder.Finish({"VALID", end.sample.state_hash}).complete);

    const recording::RecordingReader reader(directory.File());
    TaskOptions replay_options;
    replay_options.safety = SupervisedOptions(setup).safety;
    replay_options.supervised = false;
    replay_options.duration_ticks = end.sample.tick;
    auto again = std::make_unique<SimulationTask>(setup.configuration.model, setup.start, replay_options);
    std::vector<simulation::RunState> recorded(end.sample.tick);
    ASSERT_EQ(reader.ReadSamples(0, recorded), end.sample.tick);
    std::size_t row = 0;
    run::RunScript(*again, reader.Stimuli(), [&] {
      const simulation::RunState& now = again->Now();
      EXPECT_EQ(now.sample.state_hash, recorded[row].sample.state_hash) << now.sample.tick;
      EXPECT_EQ(now.status.mode, recorded[row].status.mode) << now.sample.tick;
      EXPECT_EQ(now.status.safety_cause, recorded[row].status.safety_cause) << now.sample.tick;
      EXPECT_EQ(now.status.command_age_ticks, recorded[row].status.command_age_ticks) << now.sample.tick;
      ++row;
      return !::testing::Test::HasFailure();
    });
    EXPECT_EQ(again->Now().sample.state_hash, end.sample.state_hash);
    std::vector<simulation::SafetyChange> replayed;
    simulation::SafetyChange change;
    while (again->TryPopSafetyChange(change)) replayed.push_back(change);
    ASSERT_EQ(replayed.size(), changes.size());
    for (std::size_t i = 0; i < changes.size(); ++i) EXPECT_EQ(replayed[i].tick, changes[i].tick);
  }
}

/// The valve closes: that is what drain is for.
TEST(SupervisedRun, DrainClosesTheValveAndFreezeLetsItStand) {
  const auto x3_after = [](const char* on_loss) {
    const testing::DefaultSetup setup(
        {std::string("safety.on_loss=") + on_loss, "safety.drain_time_constant_s=0.05"});
    SimulationTask task(setup.configuration.model, setup.start, SupervisedOptions(setup));
    testing::Governor(task).Send(setup.start.p1_psi);
    task.Run(15'000);
    EXPECT_EQ(task.Now().status.mode, simulation::Mode::kDegraded);
    return task.Now().sample.state.x3_in;
  };
  EXPECT_LT(x3_after("drain"), 0.01);
  EXPECT_NEAR(x3_after("hold"), 4.0, 0.001);
  EXPECT_NEAR(x3_after("freeze"), 4.0, 0.001);
}

TEST(SupervisedRun, ASnapshotCarriesTheSupervision) {
  const testing::DefaultSetup setup;
  TaskOptions options = SupervisedOptions(setup);
  options.snapshot_ticks = {250, 400};  // before and after the loss
  SimulationTask whole(setup.configuration.model, setup.start, options);
  testing::Governor(whole).Send(setup.start.p1_psi);
  whole.Run(2'000);
  Snapshot snapshot;
  while (whole.TryPopSnapshot(snapshot)) {
    SimulationTask rest(setup.configuration.model, setup.start, SupervisedOptions(setup));
    rest.Restore(snapshot);
    rest.Run(static_cast<int>(2'000 - snapshot.sample.tick));
    EXPECT_EQ(rest.Now().sample.state_hash, whole.Now().sample.state_hash) << snapshot.sample.tick;
    EXPECT_EQ(rest.Now().status.mode, simulation::Mode::kDegraded);
    EXPECT_EQ(rest.Now().status.losses, 1U);
  }
  EXPECT_EQ(snapshot.sample.tick, 400U);
}

TEST(SupervisedRun, FaultedIsToldOnce) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.configuration.model, setup.start, SupervisedOptions(setup));
  testing::Governor governor(task);
  governor.Send(std::numeric_limits<double>::quiet_NaN());
  task.Run(100);
  simulation::SafetyChange change;
  ASSERT_TRUE(task.TryPopSafetyChange(change));
  EXPECT_EQ(change.to, simulation::SafetyState::kRunning);
  ASSERT_TRUE(task.TryPopSafetyChange(change));
  EXPECT_EQ(change.to, simulation::SafetyState::kFaulted);
  EXPECT_EQ(change.tick, 1U);
  EXPECT_FALSE(task.TryPopSafetyChange(change));
  EXPECT_EQ(task.Now().status.mode, simulation::Mode::kModelFault);
}

}  // namespace
}  // namespace servohil::emulator
