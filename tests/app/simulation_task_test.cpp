#include <gtest/gtest.h>

#include <cmath>

#include "default_setup.hpp"

namespace servohil::app {
namespace {

TEST(SimulationTask, IsTheOfflineSimulationTickByTick) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.derived, setup.start, setup.contract, setup.Options());
  Simulation offline(setup.derived, setup.start);
  const rt::LoopTiming in_time;
  for (int wake = 0; wake < 200; ++wake) {
    if (wake == 20) task.PutCommand({setup.start.p1_psi + 0.27});
    if (wake == 100) task.PutCommand({setup.start.p1_psi - 0.5});
    task.Wake(in_time);
    for (int i = 0; i < setup.configuration.loop.wake_ticks; ++i) {
      if (wake < 20) {
        offline.Rest();
      } else {
        offline.Tick(setup.start.p1_psi + (wake < 100 ? 0.27 : -0.5));
      }
    }
    ASSERT_EQ(task.Final().sample.state.Vector(), offline.Now().state.Vector()) << "wake-up " << wake;
  }
  EXPECT_EQ(task.Final().sample.tick, 2'000U);
}

TEST(SimulationTask, PublishesEachMessageAtItsCycleWhateverTheWakePeriod) {
  for (const char* wake_ticks : {"1", "7", "10", "100"}) {
    const testing::DefaultSetup setup({std::string("loop.wake_ticks=") + wake_ticks});
    SimulationTask task(setup.derived, setup.start, setup.contract, setup.Options());
    const rt::LoopTiming in_time;
    std::array<int, kPublishedCount> published{};
    Telemetry t;
    while (task.Final().sample.tick < 10'000) {
      task.Wake(in_time);
      while (task.TryPopTelemetry(t)) {
        for (std::size_t i = 0; i < kPublishedCount; ++i) {
          if (t.due[i] && t.sample.tick <= 10'000) ++published[i];
        }
      }
    }
    // 1 s: 10 ms, 10 ms, 100 ms, 100 ms.
    EXPECT_EQ(published, (std::array<int, kPublishedCount>{100, 100, 10, 10})) << "wake_ticks " << wake_ticks;
    EXPECT_EQ(task.TelemetryDropped(), 0U);
  }
}

TEST(SimulationTask, CountsTheTicksOfLateWakeUpsAndLatchesTimingInvalid) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.derived, setup.start, setup.contract, setup.Options());
  rt::LoopTiming timing;
  task.Wake(timing);
  EXPECT_TRUE(task.Final().status.timing_valid);
  timing.late_wakes = 3;
  timing.worst_lateness_ns = 1'234'567;
  task.Wake(timing);
  EXPECT_FALSE(task.Final().status.timing_valid);
  EXPECT_EQ(task.Final().status.late_ticks, 30U);
  EXPECT_EQ(task.Final().status.worst_lateness_ns, 1'234'567);
}

TEST(SimulationTask, CommandAgeAndModeFollowTheCommands) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.derived, setup.start, setup.contract, setup.Options());
  const rt::LoopTiming in_time;
  task.Wake(in_time);
  EXPECT_EQ(task.Final().status.mode, Mode::kWaiting);
  EXPECT_FALSE(task.Final().status.commanded);
  task.PutCommand({30.0});
  task.Wake(in_time);
  task.Wake(in_time);
  EXPECT_EQ(task.Final().status.mode, Mode::kRunning);
  EXPECT_EQ(task.Final().status.command_age_ticks, 20U);
  task.PutCommand(
      {std::nan("")});  // the contract lets none through; the model must not show its effect either
  task.Wake(in_time);
  EXPECT_EQ(task.Final().status.mode, Mode::kModelFault);
}

TEST(SimulationTask, EndsAtTheExactTick) {
  const testing::DefaultSetup setup;
  EmulatorOptions options = setup.Options();
  options.duration_ticks = 25;
  SimulationTask task(setup.derived, setup.start, setup.contract, options);
  const rt::LoopTiming in_time;
  EXPECT_TRUE(task.Wake(in_time));
  EXPECT_TRUE(task.Wake(in_time));
  EXPECT_FALSE(task.Wake(in_time));
  EXPECT_EQ(task.Final().sample.tick, 25U);
}

}  // namespace
}  // namespace servohil::app
