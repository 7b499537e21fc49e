// Faults in the simulation thread's work: what they do to what is published, that they are told of, and that
// a replay of the stimuli gives the same run.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>

#include "base/error.hpp"
#include "can/dbc/codec.hpp"
#include "fault_words/injection_words.hpp"
#include "simulation/quantity.hpp"
#include "support/default_setup.hpp"

namespace servohil::emulator {
namespace {

class FaultBench {
 public:
  explicit FaultBench(const testing::DefaultSetup& setup)
      : setup_(setup),
        task(std::make_unique<SimulationTask>(setup.configuration.model, setup.start, setup.Options())) {}

  FaultBench& Inject(const std::string& fault, const fault_words::Words& words) {
    fault_words::FaultContext context;
    context.signal_map = &setup_.signal_map;
    context.surroundings.unfaulted = &setup_.configuration.model;
    simulation::Request request;
    request.injection = fault_words::UnderstandInjection(fault, words, context).injection;
    EXPECT_TRUE(task->PutRequest(request));
    return *this;
  }
  /// Ticks under P1 0.4 psi above rest.
  FaultBench& For(int ticks) {
    command_.p1_psi = setup_.start.p1_psi + 0.4;
    ++command_.counts.Of(simulation::FrameVerdict::kValid);
    ++command_.good;
    task->PutCommand(command_);
    task->Run(ticks);
    return *this;
  }
  std::vector<simulation::Publication> Published() {
    std::vector<simulation::Publication> all;
    for (simulation::Publication one; task->TryPopPublication(one);) all.push_back(one);
    return all;
  }
  std::vector<std::string> Told() {
    std::vector<std::string> all;
    for (fault::Event event; task->TryPopFaultEvent(event);)
      all.push_back(fault_words::EventText(event, &setup_.signal_map));
    return all;
  }
  simulation::Answer::Result Answered() {
    simulation::Answer answer;
    EXPECT_TRUE(task->TryPopAnswer(answer));
    return answer.result;
  }

 private:
  const testing::DefaultSetup& setup_;
  simulation::Command command_;  ///< newest of the governor

 public:
  std::unique_ptr<SimulationTask> task;
};

double SignalIn(const testing::DefaultSetup& setup, std::size_t message, const char* name,
                const simulation::Publication& p) {
  const can::Frame frame = setup.signal_map.Encode(message, p.run_state, p.measured);
  return can::Decode(*setup.signal_map.MessageOf(message).FindSignal(name), {frame.data.data(), frame.size});
}

TEST(FaultTask, AFrozenSensorsFramesAreConstantWhileTheTruthMoves) {
  const testing::DefaultSetup setup;
  FaultBench run(setup);
  run.Inject("sensor_frozen", {{"signal", "x3"}, {"at_s", 0.05}, {"for_s", 0.1}}).For(3'000);
  double frozen = 0.0;
  int held = 0;
  for (const simulation::Publication& p : run.Published()) {
    if (!simulation::Has(p.run_state.due, testing::kPosition)) continue;
    const double said = SignalIn(setup, testing::kPosition, "X3", p);
    const double truth = p.run_state.sample.state.x3_in;
    const std::uint64_t tick = p.run_state.sample.tick;
    if (tick <= 500 || tick > 1'500) {
      EXPECT_NEAR(said, truth, 1.0001e-4) << tick;
    } else {
      if (held++ == 0) frozen = said;
      EXPECT_EQ(said, frozen);
      if (tick == 1'500) {
        EXPECT_GT(truth - said, 0.01);
      }
    }
  }
  EXPECT_EQ(held, 10);
}

TEST(FaultTask, WhatIsNotAvailableHasAllOnes) {
  const testing::DefaultSetup setup;
  FaultBench run(setup);
  run.Inject("sensor_open_wire", {{"signal", "p3"}}).Inject("sensor_full_scale", {{"signal", "p4"}}).For(100);
  const simulation::Publication last = run.Published().back();
  const can::Frame frame = setup.signal_map.Encode(testing::kPressures, last.run_state, last.measured);
  EXPECT_EQ(frame.data[2], 0xFF);
  EXPECT_EQ(frame.data[3], 0xFF);
  const can::Signal& p4 = *setup.signal_map.MessageOf(testing::kPressures).FindSignal("P4");
  EXPECT_NEAR(SignalIn(setup, testing::kPressures, "P4", last), p4.maximum, p4.factor);
}

TEST(FaultTask, TheTruthIsThatOfARunWithoutSensorAndBusFaults) {
  const testing::DefaultSetup setup;
  FaultBench with(setup);
  FaultBench without(setup);
  with.Inject("sensor_noise", {{"signal", "x3"}}).Inject("sensor_delayed", {{"signal", "p3"}}).For(1);
  with.Inject("tx_lost", {{"probability", 0.5}}).Inject("tx_jittered", {}).For(999);
  without.For(1'000);
  EXPECT_EQ(with.task->Now().sample.state_hash, without.task->Now().sample.state_hash);
}

TEST(FaultTask, EachMessageOfAFaultedTickHasItsOwnFate) {
  const testing::DefaultSetup setup;
  FaultBench run(setup);
  run.Inject("tx_lost", {{"message", "SERVO_Position"}, {"probability", 1.0}}).For(1'000);
  int lost = 0;
  int sent = 0;
  for (const simulation::Publication& p : run.Published()) {
    EXPECT_EQ(p.fate.lost, p.run_state.due == simulation::SetOf(testing::kPosition));
    (p.fate.lost ? lost : sent) += 1;
  }
  EXPECT_EQ(lost, 10);
  EXPECT_EQ(sent, 10 + 1 + 1 + 1) << "pressures, relay, safety, status";
}

TEST(FaultTask, AConditionOnTheTruthStartsItAndAllIsTold) {
  const testing::DefaultSetup setup;
  FaultBench run(setup);
  run.Inject("cold_oil", {{"when", "x3_in > 4.1"}, {"for_s", 0.01}}).For(1);
  EXPECT_EQ(run.Told(), (std::vector<std::string>{"fault cold_oil waits from tick 1 (0.0001 s)"}));
  std::uint64_t crossed = 0;
  for (int tick = 2; tick <= 3'000; ++tick) {
    run.For(1);
    if (crossed == 0 && run.task->Now().sample.state.x3_in > 4.1) crossed = run.task->Now().sample.tick;
    EXPECT_EQ(run.task->Now().status.active_faults, crossed != 0 && run.task->Now().sample.tick > crossed &&
                                                            run.task->Now().sample.tick <= crossed + 100
                                                        ? 1U
                                                        : 0U)
        << tick;
  }
  ASSERT_NE(crossed, 0U);
  EXPECT_EQ(run.Told().size(), 2U) << "start and end";
}

TEST(FaultTask, AFrameStartsItWithTheNextTick) {
  const testing::DefaultSetup setup;
  FaultBench run(setup);
  run.Inject("load_step", {{"when_frame", "0x123"}, {"for_s", 0.01}}).For(10);
  run.task->PutFrame(0x124, false);
  run.For(10);
  EXPECT_EQ(run.task->Now().status.active_faults, 0U);
  run.task->PutFrame(0x123, false);
  run.For(1);
  EXPECT_EQ(run.task->Now().status.active_faults, 1U);
  run.For(100);
  EXPECT_EQ(run.task->Now().status.active_faults, 0U);
}

TEST(FaultTask, GoesOnFromASnapshotAsIfItHadNeverEnded) {
  const testing::DefaultSetup setup;
  TaskOptions options = setup.Options();
  FaultBench whole(setup);
  whole.Inject("sensor_frozen", {{"signal", "x3"}, {"at_s", 0.02}})
      .Inject("cold_oil", {{"when", "x3_in > 4.1"}, {"for_s", 0.05}, {"times", 0.0}})
      .Inject("load_step", {{"psi", 5.0}, {"every_s", 0.03}, {"ramp_s", 0.005}})
      .For(1'000);
  whole.task->PutRequest({.kind = simulation::Request::Kind::kSnapshot});
  whole.For(1);
  Snapshot snapshot;
  ASSERT_TRUE(whole.task->TryPopSnapshot(snapshot));
  FaultBench rest(setup);
  rest.task->Restore(snapshot);
  whole.Published();
  whole.For(2'000);
  rest.For(1).For(2'000);
  EXPECT_EQ(whole.task->Now().sample.state_hash, rest.task->Now().sample.state_hash);
  const simulation::Publication of_whole = whole.Published().back();
  const simulation::Publication of_rest = rest.Published().back();
  for (const simulation::Quantity& quantity : simulation::Quantities()) {
    if (!quantity.repeatable) continue;  // frames are counted from the start of the process
    EXPECT_EQ(of_whole.measured.values[simulation::IndexOf(quantity)],
              of_rest.measured.values[simulation::IndexOf(quantity)])
        << quantity.name;
  }
}

TEST(FaultTask, NoSnapshotHoldsThePastThatADelayNeeds) {
  const testing::DefaultSetup setup;
  FaultBench run(setup);
  run.Inject("sensor_delayed", {{"signal", "x3"}}).For(1);
  EXPECT_EQ(run.Answered(), simulation::Answer::Result::kApplied);
  run.task->PutRequest({.kind = simulation::Request::Kind::kSnapshot});
  run.For(1);
  EXPECT_EQ(run.Answered(), simulation::Answer::Result::kNoSnapshot);
  EXPECT_EQ(run.task->SnapshotsRefused(), 1U);
  Snapshot snapshot;
  EXPECT_FALSE(run.task->TryPopSnapshot(snapshot));
}

TEST(FaultTask, MissedTicksStallsOnceForEachPulse) {
  const testing::DefaultSetup setup;
  static std::vector<double> stalls;
  stalls.clear();
  TaskOptions options = setup.Options();
  options.stall = [](double ms) noexcept { stalls.push_back(ms); };
  FaultBench run(setup);
  run.task = std::make_unique<SimulationTask>(setup.configuration.model, setup.start, options);
  run.Inject("missed_ticks", {{"ms", 30.0}, {"every_s", 0.01}, {"times", 3.0}}).For(1'000);
  EXPECT_EQ(stalls, (std::vector<double>{30.0, 30.0, 30.0}));
}

TEST(FaultTask, InterfaceDownIsInTheStatus) {
  const testing::DefaultSetup setup;
  FaultBench run(setup);
  run.Inject("interface_down", {{"for_s", 0.01}}).For(1);
  EXPECT_TRUE(run.task->Now().status.line_down);
  run.For(100);
  EXPECT_FALSE(run.task->Now().status.line_down);
}

std::string WarningOf(const std::string& fault, const fault_words::Words& words) {
  const testing::DefaultSetup setup;
  fault_words::FaultContext context;
  context.signal_map = &setup.signal_map;
  context.surroundings.unfaulted = &setup.configuration.model;
  return fault_words::UnderstandInjection(fault, words, context).warning;
}

TEST(FaultWords, WarnOfWhatWouldHaveNoEffect) {
  EXPECT_EQ(WarningOf("air_entrainment", {{"fraction", 0.0}}),
            "no effect: with these values all stays what it is");
  EXPECT_EQ(WarningOf("bulk_modulus", {{"psi", 110'000.0}}),
            "no effect: with these values all stays what it is");
  EXPECT_EQ(WarningOf("sensor_gain", {{"signal", "x3"}, {"factor", 1.0}}),
            "no effect: with these values all stays what it is");
  EXPECT_EQ(WarningOf("tx_lost", {{"probability", 0.0}}), "no effect: probability = 0");
  EXPECT_EQ(WarningOf("tx_delayed", {{"delay_ms", 0.0}}),
            "no effect: with these values all stays what it is");
  EXPECT_EQ(WarningOf("babbling", {{"rate_hz", 0.0}}), "no effect: with these values all stays what it is");
}

TEST(FaultWords, AreSilentWhereEveryFaultsPresetsHaveAnEffect) {
  const testing::DefaultSetup setup({"stabilizer.enabled=true"});
  fault_words::FaultContext context;
  context.signal_map = &setup.signal_map;
  context.surroundings.unfaulted = &setup.configuration.model;
  context.surroundings.counter = true;
  context.surroundings.checksum = true;
  for (const fault::Spec& spec : fault::Catalogue()) {
    const fault_words::Words words =
        spec.HasSignal() ? fault_words::Words{{"signal", "x3"}} : fault_words::Words{};
    EXPECT_EQ(fault_words::UnderstandInjection(spec.name, words, context).warning, "") << spec.name;
  }
}

TEST(FaultWords, GiveTheTimeLineInTicks) {
  const testing::DefaultSetup setup;
  fault_words::FaultContext context;
  context.signal_map = &setup.signal_map;
  context.surroundings.unfaulted = &setup.configuration.model;
  const fault::Injection once =
      fault_words::UnderstandInjection("cold_oil", {{"at_s", 1.0}, {"ramp_s", 0.1}, {"for_s", 2.0}}, context)
          .injection;
  EXPECT_EQ(once.start_tick, 10'001U);
  EXPECT_EQ(once.ramp_ticks, 1'000U);
  EXPECT_EQ(once.ramp_out_ticks, 1'000U);
  EXPECT_EQ(once.for_ticks, 20'000U);
  EXPECT_EQ(once.times, 1U);
  const fault::Injection often =
      fault_words::UnderstandInjection(
          "cold_oil", {{"every_s", 1.0}, {"duty", 0.3}, {"times", 5.0}, {"ramp_out_s", 0.2}}, context)
          .injection;
  EXPECT_EQ(often.period_ticks, 10'000U);
  EXPECT_EQ(often.for_ticks, 3'000U);
  EXPECT_EQ(often.ramp_out_ticks, 2'000U);
  EXPECT_EQ(often.times, 5U);
}

}  // namespace
}  // namespace servohil::emulator
