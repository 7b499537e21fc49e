#include <gtest/gtest.h>

#include <cmath>

#include "support/default_setup.hpp"

namespace servohil::emulator {
namespace {

TEST(SimulationTask, IsTheOfflineSimulationTickByTick) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.configuration.model, setup.start, setup.Options());
  testing::Governor governor(task);
  simulation::Simulation offline(setup.configuration.model, setup.start);
  const rt::LoopTiming in_time;
  for (int wake = 0; wake < 200; ++wake) {
    if (wake == 20) governor.Send(setup.start.p1_psi + 0.27);
    if (wake == 100) governor.Send(setup.start.p1_psi - 0.5);
    task.Wake(in_time);
    for (int i = 0; i < setup.configuration.loop.wake_ticks; ++i) {
      if (wake < 20) {
        offline.Rest();
      } else {
        offline.Tick(setup.start.p1_psi + (wake < 100 ? 0.27 : -0.5));
      }
    }
    ASSERT_EQ(task.Now().sample.state.Vector(), offline.Now().state.Vector()) << "wake-up " << wake;
  }
  EXPECT_EQ(task.Now().sample.tick, 2'000U);
}

TEST(SimulationTask, PublishesEachMessageAtItsCycleWhateverTheWakePeriod) {
  for (const char* wake_ticks : {"1", "7", "10", "100"}) {
    const testing::DefaultSetup setup({std::string("loop.wake_ticks=") + wake_ticks});
    SimulationTask task(setup.configuration.model, setup.start, setup.Options());
    const rt::LoopTiming in_time;
    std::array<int, testing::kMessageCount> published{};
    simulation::Publication p;
    while (task.Now().sample.tick < 10'000) {
      task.Wake(in_time);
      while (task.TryPopPublication(p)) {
        const simulation::RunState& t = p.run_state;
        for (std::size_t i = 0; i < testing::kMessageCount; ++i) {
          if (simulation::Has(t.due, i) && t.sample.tick <= 10'000) ++published[i];
        }
      }
    }
    // 1 s: 10 ms, 10 ms, 100 ms, 1 s, 100 ms, 100 ms.
    EXPECT_EQ(published, (std::array<int, testing::kMessageCount>{100, 100, 10, 1, 10, 10}))
        << "wake_ticks " << wake_ticks;
    EXPECT_EQ(task.PublicationsDropped(), 0U);
  }
}

rt::LateWake Late(rt::LateCause cause, std::int64_t lateness_ns) {
  return {.lateness_ns = lateness_ns, .cause = cause};
}

TEST(SimulationTask, CountsTheTicksOfLateWakeUpsByCauseAndLatchesTimingInvalid) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.configuration.model, setup.start, setup.Options());
  rt::LoopTiming timing;
  task.Wake(timing);
  EXPECT_TRUE(task.Now().status.TimingValid());
  timing.late.Record(Late(rt::LateCause::kWokeLate, 1'000'000));
  timing.late.Record(Late(rt::LateCause::kWokeLate, 1'000'000));
  timing.late.Record(Late(rt::LateCause::kComputedLong, 1'000'000));
  timing.worst_lateness_ns = 1'234'567;
  task.Wake(timing);
  const simulation::Status& status = task.Now().status;
  EXPECT_FALSE(status.TimingValid());
  EXPECT_EQ(status.late.woke_late, 20U);
  EXPECT_EQ(status.late.computed_long, 10U);
  EXPECT_EQ(status.late.Total(), 30U);
  EXPECT_EQ(status.worst_lateness_ns, 1'234'567);
}

TEST(SimulationTask, RecentLatenessIsThatSinceTheStatusBefore) {
  const testing::DefaultSetup setup;  // a status every 100 ms, a wake-up every 1 ms
  SimulationTask task(setup.configuration.model, setup.start, setup.Options());
  std::vector<std::int64_t> told;
  for (int wake = 1; wake <= 300; ++wake) {
    rt::LoopTiming timing;
    timing.lateness_ns = wake == 50 ? 700'000 : wake == 150 ? 300'000 : 1'000;
    task.Wake(timing);
    simulation::Publication p;
    while (task.TryPopPublication(p)) {
      const simulation::RunState& t = p.run_state;
      if (simulation::Has(t.due, testing::kStatus)) told.push_back(t.status.recent_lateness_ns);
    }
  }
  EXPECT_EQ(told, (std::vector<std::int64_t>{700'000, 300'000, 1'000}));
}

/// A wake-up that finds so many ticks to catch up, and the nine that follow it.
void WakeBehind(SimulationTask& task, std::uint64_t wakes_behind) {
  rt::LoopTiming timing;
  for (std::uint64_t left = wakes_behind + 1; left-- > 0;) {
    timing.behind = left;
    if (left > 0)
      timing.late.Record(Late(rt::LateCause::kWokeLate, static_cast<std::int64_t>(left) * 1'000'000));
    if (!task.Wake(timing)) return;
  }
}

TEST(SimulationTask, WithinTheLimitEveryPolicyCatchesUp) {
  for (const char* policy : {"catch_up", "freeze", "stop"}) {
    const testing::DefaultSetup setup({std::string("loop.overrun=") + policy, "loop.max_catch_up_ticks=100"});
    SimulationTask task(setup.configuration.model, setup.start, setup.Options());
    WakeBehind(task, 10);
    EXPECT_EQ(task.Now().sample.tick, 110U) << policy;
    EXPECT_EQ(task.Now().status.overruns, 0U) << policy;
  }
}

TEST(SimulationTask, PastTheLimitCatchUpLosesNoTickAndCountsTheOverrunOnce) {
  const testing::DefaultSetup setup({"loop.max_catch_up_ticks=100"});
  SimulationTask task(setup.configuration.model, setup.start, setup.Options());
  WakeBehind(task, 30);
  EXPECT_EQ(task.Now().sample.tick, 310U);
  EXPECT_EQ(task.Now().status.overruns, 1U);
  EXPECT_FALSE(task.Now().status.TimingValid());
}

TEST(SimulationTask, PastTheLimitFreezeHoldsTheStateAndGoesOnPublishing) {
  const testing::DefaultSetup setup({"loop.overrun=freeze", "loop.max_catch_up_ticks=100"});
  TaskOptions options = setup.Options();
  options.duration_ticks = 2'000;
  SimulationTask task(setup.configuration.model, setup.start, options);
  const rt::LoopTiming in_time;
  testing::Governor governor(task);
  governor.Send(setup.start.p1_psi + 1.0);
  for (int i = 0; i < 20; ++i) task.Wake(in_time);
  const simulation::Sample before = task.Now().sample;
  WakeBehind(task, 30);
  governor.Send(setup.start.p1_psi - 1.0);
  EXPECT_TRUE(task.Wake(in_time)) << "the run goes on";
  EXPECT_EQ(task.Now().sample.tick, before.tick);
  EXPECT_EQ(task.Now().sample.state_hash, before.state_hash);
  EXPECT_EQ(task.Now().status.mode, simulation::Mode::kFrozen);
  simulation::Publication p;
  int positions = 0;
  while (task.TryPopPublication(p)) {
    const simulation::RunState& t = p.run_state;
    positions +=
        simulation::Has(t.due, testing::kPosition) && t.status.mode == simulation::Mode::kFrozen ? 1 : 0;
  }
  EXPECT_EQ(positions, 3) << "32 ms of a 10 ms cycle";
  int wakes = 1;
  while (task.Wake(in_time)) ++wakes;
  EXPECT_EQ(200 + 320 + wakes * 10, 2'000) << "the duration is over when it would have been";
}

TEST(SimulationTask, PastTheLimitStopEndsTheRunAtTheTickItHadReached) {
  const testing::DefaultSetup setup({"loop.overrun=stop", "loop.max_catch_up_ticks=100"});
  SimulationTask task(setup.configuration.model, setup.start, setup.Options());
  rt::LoopTiming timing;
  EXPECT_TRUE(task.Wake(timing));
  timing.behind = 11;
  EXPECT_FALSE(task.Wake(timing));
  EXPECT_EQ(task.Now().sample.tick, 10U);
  EXPECT_EQ(task.Now().status.overruns, 1U);
}

TEST(SimulationTask, InTheGraceNothingIsAnOverrun) {
  const testing::DefaultSetup setup({"loop.overrun=stop", "loop.max_catch_up_ticks=0"});
  SimulationTask task(setup.configuration.model, setup.start, setup.Options());
  rt::LoopTiming timing;
  timing.behind = 11;
  timing.in_grace = true;
  EXPECT_TRUE(task.Wake(timing));
  EXPECT_EQ(task.Now().status.overruns, 0U);
}

TEST(SimulationTask, ARestoredRunGoesOnBitForBit) {
  const testing::DefaultSetup setup({"friction.coulomb_psi=5", "friction.breakaway_psi=7",
                                     "stabilizer.enabled=true", "oil.air_fraction=0.01"});
  TaskOptions options = setup.Options();
  options.snapshot_ticks = {333, 1'500};
  SimulationTask whole(setup.configuration.model, setup.start, options);
  const auto drive = [&](SimulationTask& task, std::uint64_t until) {
    testing::Governor governor(task);
    while (task.Now().sample.tick < until) {
      const std::uint64_t tick = task.Now().sample.tick;
      if (tick == 100 || tick == 900) governor.Send(setup.start.p1_psi + (tick == 100 ? 3.0 : -3.0));
      task.Run(1);
    }
  };
  drive(whole, 3'000);
  Snapshot snapshot;
  for (const std::uint64_t tick : options.snapshot_ticks) {
    ASSERT_TRUE(whole.TryPopSnapshot(snapshot));
    ASSERT_EQ(snapshot.sample.tick, tick);
    SimulationTask rest(setup.configuration.model, setup.start, setup.Options());
    rest.Restore(snapshot);
    drive(rest, 3'000);
    EXPECT_EQ(rest.Now().sample.state_hash, whole.Now().sample.state_hash);
    EXPECT_EQ(rest.Now().sample.state.Vector(), whole.Now().sample.state.Vector());
    EXPECT_EQ(rest.Now().status.command_age_ticks, whole.Now().status.command_age_ticks);
  }
  EXPECT_FALSE(whole.TryPopSnapshot(snapshot));
}

TEST(SimulationTask, ASnapshotIsTakenBetweenTicksWhenAskedFor) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.configuration.model, setup.start, setup.Options());
  task.Run(7);
  task.PutRequest({.number = 5, .kind = simulation::Request::Kind::kSnapshot});
  task.Run(5);
  Snapshot snapshot;
  ASSERT_TRUE(task.TryPopSnapshot(snapshot));
  EXPECT_EQ(snapshot.sample.tick, 7U);
  EXPECT_FALSE(task.TryPopSnapshot(snapshot)) << "one request, one snapshot";
  simulation::Answer answer;
  ASSERT_TRUE(task.TryPopAnswer(answer));
  EXPECT_EQ(answer.number, 5U);
  EXPECT_EQ(answer.tick, 7U);
}

TEST(SimulationTask, CommandAgeAndModeFollowTheCommands) {
  const testing::DefaultSetup setup;
  SimulationTask task(setup.configuration.model, setup.start, setup.Options());
  const rt::LoopTiming in_time;
  task.Wake(in_time);
  EXPECT_EQ(task.Now().status.mode, simulation::Mode::kWaiting);
  EXPECT_FALSE(task.Now().status.commanded);
  testing::Governor governor(task);
  governor.Send(30.0);
  task.Wake(in_time);
  task.Wake(in_time);
  EXPECT_EQ(task.Now().status.mode, simulation::Mode::kRunning);
  EXPECT_EQ(task.Now().status.command_age_ticks, 20U);
  governor.Send(std::nan(""));  // the validator lets none through; the model must not show its effect either
  task.Wake(in_time);
  EXPECT_EQ(task.Now().status.mode, simulation::Mode::kModelFault);
}

TEST(SimulationTask, EndsAtTheExactTick) {
  const testing::DefaultSetup setup;
  TaskOptions options = setup.Options();
  options.duration_ticks = 25;
  SimulationTask task(setup.configuration.model, setup.start, options);
  const rt::LoopTiming in_time;
  EXPECT_TRUE(task.Wake(in_time));
  EXPECT_TRUE(task.Wake(in_time));
  EXPECT_FALSE(task.Wake(in_time));
  EXPECT_EQ(task.Now().sample.tick, 25U);
}

}  // namespace
}  // namespace servohil::emulator
