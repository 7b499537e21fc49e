#include "simulation/command_monitor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "model/step.hpp"

namespace servohil::simulation {
namespace {

using S = SafetyState;
using Cause = SafetyCause;

/// A supervision with the defaults of the configuration, tick by tick, and the receiver's side of it.
class Bench {
 public:
  explicit Bench(configuration::SafetySettings settings = {})
      : monitor_(LawOf(configuration::Resolved(settings, 10))) {}

  void Valid(double p1_psi, bool enabled = true, bool trip = false) {
    command_.p1_psi = p1_psi;
    command_.enabled = enabled;
    command_.trip = trip;
    ++command_.counts.Of(FrameVerdict::kValid);
    if (trip) ++command_.trips;
    const bool good = enabled && !trip;
    if (good) ++command_.good;
    command_.good_in_a_row = good ? command_.good_in_a_row + 1 : 0;
  }
  void Invalid(FrameVerdict verdict = FrameVerdict::kCorrupted) {
    ++command_.counts.Of(verdict);
    command_.good_in_a_row = 0;
  }
  /// @return the first tick of these that changed the state, counted from 1; 0: none
  int Ticks(int count, bool counts = true, bool fresh_enough = true) {
    int changed_at = 0;
    for (int i = 1; i <= count; ++i) {
      if (monitor_.Hear(command_, fresh_enough)) monitor_.SetDemand(command_.p1_psi);
      if (const auto decision = monitor_.Decide(counts)) {
        monitor_.Change(*decision);
        if (changed_at == 0) changed_at = i;
      }
      if (!monitor_.Rests()) p1_psi_ = monitor_.P1(p1_psi_);
    }
    return changed_at;
  }
  void Frame(double p1_psi) {
    Valid(p1_psi);
    Ticks(100);
  }

  S State() const { return monitor_.Now().state; }
  Cause Why() const { return monitor_.Now().cause; }
  double P1() const { return p1_psi_; }
  CommandMonitor& Get() { return monitor_; }

 private:
  CommandMonitor monitor_;
  Command command_;
  double p1_psi_ = 30.0;
};

TEST(CommandMonitor, WaitsForTheFirstValidFrame) {
  Bench bench;
  bench.Invalid();
  bench.Ticks(10'000);
  EXPECT_EQ(bench.State(), S::kWaiting);
  EXPECT_EQ(bench.P1(), 30.0);
  bench.Valid(31.0);
  EXPECT_EQ(bench.Ticks(1), 1);
  EXPECT_EQ(bench.State(), S::kRunning);
  EXPECT_EQ(bench.Why(), Cause::kCommand);
  EXPECT_EQ(bench.P1(), 31.0);
}

TEST(CommandMonitor, IsLostAfterThreeCyclesOfSilenceToTheTick) {
  Bench bench;
  bench.Valid(31.0);
  bench.Ticks(1);
  EXPECT_EQ(bench.Ticks(299), 0);
  EXPECT_EQ(bench.Ticks(1), 1) << "30 ms after the frame was used";
  EXPECT_EQ(bench.State(), S::kDegraded);
  EXPECT_EQ(bench.Why(), Cause::kSilence);
}

TEST(CommandMonitor, FramesThatAreNotValidDoNotEndTheSilenceButNameTheCause) {
  Bench bench;
  bench.Frame(31.0);
  for (int i = 0; i < 2; ++i) {
    bench.Invalid();
    EXPECT_EQ(bench.Ticks(100), 0);
  }
  bench.Invalid();
  EXPECT_EQ(bench.Ticks(100), 1);
  EXPECT_EQ(bench.Why(), Cause::kInvalidFrames);
}

TEST(CommandMonitor, ATimeOutOfZeroIsNone) {
  configuration::SafetySettings settings;
  settings.timeout_ms = 0;
  Bench bench(settings);
  bench.Frame(31.0);
  EXPECT_EQ(bench.Ticks(1'000'000), 0);
  EXPECT_EQ(bench.P1(), 31.0);
}

TEST(CommandMonitor, TheEmulatorsOwnLatenessIsNobodysSilence) {
  Bench bench;
  bench.Frame(31.0);
  EXPECT_EQ(bench.Ticks(100'000, false), 0) << "caught up";
  EXPECT_EQ(bench.Ticks(199), 0);
  EXPECT_EQ(bench.Ticks(2), 2);
}

TEST(CommandMonitor, DrainFollowsItsTimeConstantToZero) {
  configuration::SafetySettings settings;
  settings.drain_time_constant_s = 0.2;
  Bench bench(settings);
  bench.Frame(100.0);
  bench.Ticks(201);
  ASSERT_EQ(bench.State(), S::kDegraded);
  bench.Ticks(2'000 - 1);  // 0.2 s with the tick of the change
  EXPECT_NEAR(bench.P1(), 100.0 * std::exp(-1.0), 100.0 * model::kTickS / (2 * 0.2))
      << "implicit Euler: relative error t dt / 2 tau²";
  bench.Ticks(2'000 * 11);
  EXPECT_EQ(bench.P1(), 0.0) << "below 0.001 psi, after 11.5 time constants";
}

TEST(CommandMonitor, ATimeConstantOfZeroDrainsAtOnce) {
  configuration::SafetySettings settings;
  settings.drain_time_constant_s = 0.0;
  Bench bench(settings);
  bench.Frame(100.0);
  bench.Ticks(201);
  ASSERT_EQ(bench.State(), S::kDegraded);
  EXPECT_EQ(bench.P1(), 0.0);
}

TEST(CommandMonitor, HoldKeepsP1AndFreezeTheModel) {
  for (const configuration::OnLoss on_loss : {configuration::OnLoss::kHold, configuration::OnLoss::kFreeze}) {
    configuration::SafetySettings settings;
    settings.on_loss = on_loss;
    Bench bench(settings);
    bench.Frame(100.0);
    bench.Ticks(300);
    ASSERT_EQ(bench.State(), S::kDegraded);
    EXPECT_EQ(bench.Get().Rests(), on_loss == configuration::OnLoss::kFreeze);
    bench.Valid(50.0);
    bench.Ticks(50);
    EXPECT_EQ(bench.P1(), 100.0) << "one valid frame is no recovery, and is not followed";
  }
}

TEST(CommandMonitor, RecoversAfterSoManyValidFramesInARow) {
  Bench bench;
  bench.Frame(31.0);
  bench.Ticks(300);
  ASSERT_EQ(bench.State(), S::kDegraded);
  bench.Frame(31.0);
  bench.Frame(31.1);
  bench.Invalid();  // begins anew
  bench.Ticks(10);
  bench.Frame(31.2);
  bench.Frame(31.3);
  EXPECT_EQ(bench.State(), S::kDegraded);
  bench.Valid(31.4);
  EXPECT_EQ(bench.Ticks(1), 1);
  EXPECT_EQ(bench.State(), S::kRunning);
  EXPECT_EQ(bench.Why(), Cause::kRecovered);
  EXPECT_EQ(bench.P1(), 31.4);
}

TEST(CommandMonitor, APauseBeginsTheCountForRecoveryAnew) {
  Bench bench;
  bench.Frame(31.0);
  bench.Ticks(300);
  bench.Frame(31.0);
  bench.Frame(31.0);
  bench.Ticks(300);
  bench.Frame(31.0);
  bench.Frame(31.0);
  EXPECT_EQ(bench.State(), S::kDegraded);
  bench.Frame(31.0);
  EXPECT_EQ(bench.State(), S::kRunning);
}

/// The mailbox holds only the newest: frames that came between two ticks count all the same.
TEST(CommandMonitor, FramesThatCameWithinOneTickCountEach) {
  Bench bench;
  bench.Frame(31.0);
  bench.Ticks(300);
  bench.Valid(31.0);
  bench.Valid(31.1);
  bench.Valid(31.2);
  EXPECT_EQ(bench.Ticks(1), 1);
  EXPECT_EQ(bench.P1(), 31.2);
}

TEST(CommandMonitor, AFrameThatHasBecomeTooOldIsNotFollowed) {
  Bench bench;
  bench.Frame(31.0);
  bench.Valid(99.0);
  EXPECT_EQ(bench.Ticks(150, true, false), 0);
  EXPECT_EQ(bench.P1(), 31.0);
  EXPECT_EQ(bench.Ticks(100), 51) << "nor does it end the silence";
}

TEST(CommandMonitor, WithoutEnableTheCommandIsNotFollowed) {
  Bench bench;
  bench.Valid(31.0, false);
  bench.Ticks(100);
  EXPECT_EQ(bench.State(), S::kWaiting);
  bench.Frame(31.0);
  ASSERT_EQ(bench.State(), S::kRunning);
  bench.Valid(31.0, false);
  EXPECT_EQ(bench.Ticks(1), 1);
  EXPECT_EQ(bench.State(), S::kDegraded);
  EXPECT_EQ(bench.Why(), Cause::kDisabled);
  EXPECT_LT(bench.P1(), 31.0);
  for (int i = 0; i < 3; ++i) bench.Frame(31.0);
  EXPECT_EQ(bench.State(), S::kRunning);
}

TEST(CommandMonitor, ATripDrainsAtOnceFromEveryStateAndLastsUntilValidFramesWithout) {
  for (const S before : {S::kWaiting, S::kRunning, S::kDegraded}) {
    Bench bench;
    if (before != S::kWaiting) bench.Frame(30.0);
    if (before == S::kDegraded) bench.Ticks(300);
    ASSERT_EQ(bench.State(), before);
    const double p1_psi = bench.P1();
    bench.Valid(30.0, true, true);
    EXPECT_EQ(bench.Ticks(1), 1);
    EXPECT_EQ(bench.State(), S::kTripped);
    EXPECT_EQ(bench.Why(), Cause::kTrip);
    EXPECT_NEAR(bench.P1(), p1_psi * std::exp(-model::kTickS / 0.05), 1e-4);
    bench.Ticks(10'000);
    EXPECT_EQ(bench.State(), S::kTripped) << "silence changes nothing";
    EXPECT_EQ(bench.P1(), 0.0);
    for (int i = 0; i < 5; ++i) {
      bench.Valid(30.0, true, true);
      bench.Ticks(100);
    }
    bench.Frame(30.0);
    bench.Frame(30.0);
    EXPECT_EQ(bench.State(), S::kTripped);
    bench.Frame(30.0);
    EXPECT_EQ(bench.State(), S::kRunning);
    EXPECT_EQ(bench.Get().Now().trips, 1U);
  }
}

TEST(CommandMonitor, ATripThatOnlyOneOfSeveralFramesInATickCarriesCounts) {
  Bench bench;
  bench.Frame(30.0);
  bench.Valid(30.0, true, true);
  bench.Valid(30.0);
  EXPECT_EQ(bench.Ticks(1), 1);
  EXPECT_EQ(bench.State(), S::kTripped);
}

TEST(CommandMonitor, P1SetLocallyIsFollowedForEverUntilTheGovernorsNextFrame) {
  Bench bench;
  EXPECT_TRUE(bench.Get().TakeLocal(40.0));
  EXPECT_EQ(bench.Ticks(1'000'000), 0);
  EXPECT_EQ(bench.State(), S::kRunning);
  EXPECT_EQ(bench.Why(), Cause::kOperator);
  EXPECT_EQ(bench.P1(), 40.0);
  bench.Valid(31.0);
  bench.Ticks(1);
  EXPECT_EQ(bench.P1(), 31.0);
  EXPECT_EQ(bench.Ticks(301), 300) << "from now on its silence matters";
  EXPECT_TRUE(bench.Get().TakeLocal(41.0)) << "an operator helps himself out of it";
  bench.Ticks(1'000);
  EXPECT_EQ(bench.P1(), 41.0);
}

TEST(CommandMonitor, NobodySetsP1LocallyInATrip) {
  Bench bench;
  bench.Valid(30.0, true, true);
  bench.Ticks(1);
  EXPECT_FALSE(bench.Get().TakeLocal(40.0));
  EXPECT_EQ(bench.State(), S::kTripped);
}

TEST(CommandMonitor, FaultedIsForEver) {
  Bench bench;
  bench.Frame(30.0);
  bench.Get().Change({S::kFaulted, Cause::kModelFault});
  for (int i = 0; i < 10; ++i) bench.Frame(30.0);
  EXPECT_EQ(bench.State(), S::kFaulted);
  EXPECT_FALSE(bench.Get().TakeLocal(40.0));
}

}  // namespace
}  // namespace servohil::simulation
