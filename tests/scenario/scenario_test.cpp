// Expectations held against made-up runs whose right verdicts are known.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "model/ticks.hpp"
#include "scenario/evaluation.hpp"

namespace servohil::scenario {
namespace {

using Kind = Expectation::Kind;

const recording::SampleColumn* Column(const std::string& name) {
  for (const recording::SampleColumn& column : recording::SampleColumns()) {
    if (name == column.name) return &column;
  }
  throw std::invalid_argument(name);
}

/// From 0.1 s to 0.3 s of a scenario of 0.4 s.
Expectation Of(Kind kind, const char* quantity = "x3_in") {
  Expectation e;
  e.kind = kind;
  e.quantity = Column(quantity);
  e.from_tick = 1'000;
  e.to_tick = 3'000;
  return e;
}

struct Course {
  std::uint64_t first_tick = 1;
  std::uint64_t last_tick = 4'000;
  std::uint64_t commanded_from = 1;
  std::uint64_t leaves_out = 0;      ///< this tick
  std::uint64_t model_fault_at = 0;  ///< from this tick on
  std::function<double(std::uint64_t tick)> x3_in = [](std::uint64_t) { return 4.0; };
};

Finding Judge(const Expectation& expectation, const Course& run) {
  Scenario scenario;
  scenario.duration_ticks = 4'000;
  scenario.expectations = {expectation};
  Evaluation evaluation(scenario);
  simulation::RunState now;
  for (std::uint64_t tick = run.first_tick; tick <= run.last_tick; ++tick) {
    now.sample.tick = tick;
    now.status.commanded = tick >= run.commanded_from;
    now.status.mode = now.status.commanded ? simulation::Mode::kRunning : simulation::Mode::kWaiting;
    now.sample.model_fault = run.model_fault_at != 0 && tick >= run.model_fault_at;
    if (now.sample.model_fault) now.status.mode = simulation::Mode::kModelFault;
    now.sample.state.x3_in = run.x3_in(tick);
    if (tick != run.leaves_out) evaluation.Take(now);
  }
  return evaluation.Judge({}).judgements[0].finding;
}

/// 4 in but at one tick.
Course Spike(std::uint64_t at, double value) {
  Course run;
  run.x3_in = [=](std::uint64_t tick) { return tick == at ? value : 4.0; };
  return run;
}

Expectation Within() {
  Expectation e = Of(Kind::kWithin);
  e.of = 4.0;
  e.within = 0.01;
  return e;
}

TEST(Within, LooksAtEveryTickOfItsTimeBothEndsIncluded) {
  EXPECT_EQ(Judge(Within(), Spike(999, 9.0)).outcome, Outcome::kPass);
  EXPECT_EQ(Judge(Within(), Spike(3'001, 9.0)).outcome, Outcome::kPass);
  for (const std::uint64_t tick : {1'000U, 2'222U, 3'000U}) {
    const Finding finding = Judge(Within(), Spike(tick, 4.5));
    EXPECT_EQ(finding.outcome, Outcome::kFail);
    EXPECT_EQ(finding.tick, tick);
    EXPECT_DOUBLE_EQ(*finding.measured, 0.5);
  }
  EXPECT_EQ(Judge(Within(), Spike(2'000, 4.01)).outcome, Outcome::kPass) << "the limit itself is within";
  EXPECT_EQ(Judge(Within(), Spike(2'000, std::nan(""))).outcome, Outcome::kFail)
      << "what is no number is not";
}

TEST(ScenarioTime, BeginsWithTheFirstCommand) {
  Course run = Spike(7'500, 9.0);  // 2,500 ticks after the first command came
  run.commanded_from = 5'001;
  run.last_tick = 9'000;
  EXPECT_EQ(Judge(Within(), run).tick, 2'500U);
  run.commanded_from = 20'000;
  EXPECT_EQ(Judge(Within(), run).outcome, Outcome::kInvalid) << "it never came";
}

TEST(Validity, AMissingTickOrAnEarlyEndIsInvalidButAFailureStands) {
  Course run;
  run.leaves_out = 3'500;
  EXPECT_EQ(Judge(Within(), run).outcome, Outcome::kInvalid);
  run = {};
  run.last_tick = 2'999;
  EXPECT_EQ(Judge(Within(), run).outcome, Outcome::kInvalid);
  run = Spike(1'500, 9.0);
  run.last_tick = 2'999;
  EXPECT_EQ(Judge(Within(), run).outcome, Outcome::kFail);
}

TEST(Validity, AModelFaultIsInvalidForWhatItTouchesAndAFailureWhereItIsForbidden) {
  Course run;
  run.model_fault_at = 2'000;
  EXPECT_EQ(Judge(Within(), run).outcome, Outcome::kInvalid);
  run.model_fault_at = 3'001;
  EXPECT_EQ(Judge(Within(), run).outcome, Outcome::kPass);
  Expectation never = Of(Kind::kModeNever);
  never.quantity = nullptr;
  never.mode = simulation::Mode::kModelFault;
  EXPECT_EQ(Judge(never, run).outcome, Outcome::kPass);
  run.model_fault_at = 2'000;
  EXPECT_EQ(Judge(never, run).outcome, Outcome::kFail);
}

TEST(Settles, TellsSinceWhen) {
  Expectation e = Within();
  e.kind = Kind::kSettles;
  const Finding finding = Judge(e, Spike(700, 9.0));
  EXPECT_EQ(finding.outcome, Outcome::kPass);
  EXPECT_DOUBLE_EQ(*finding.measured, 0.0701);
  EXPECT_EQ(Judge(e, Spike(1'200, 9.0)).outcome, Outcome::kFail);
}

TEST(Between, TakesEitherLimitAlone) {
  Expectation above = Of(Kind::kBetween);
  above.above = 3.9;
  EXPECT_EQ(Judge(above, Spike(2'000, 9.0)).outcome, Outcome::kPass);
  EXPECT_EQ(Judge(above, Spike(2'000, 3.8)).outcome, Outcome::kFail);
}

Course Sine(double amplitude, double frequency_hz, std::uint64_t ends_at = 4'000) {
  Course run;
  run.x3_in = [=](std::uint64_t tick) {
    const double phase = 2.0 * std::numbers::pi * frequency_hz * model::SecondsOf(std::min(tick, ends_at));
    return 4.0 + amplitude * std::sin(phase);
  };
  return run;
}

TEST(Calm, IsFromTheLeastToTheMost) {
  Expectation e = Of(Kind::kCalm);
  e.peak_to_peak = 0.02;
  EXPECT_EQ(Judge(e, Sine(0.0099, 100.0)).outcome, Outcome::kPass);
  EXPECT_EQ(Judge(e, Sine(0.0101, 100.0)).outcome, Outcome::kFail);
}

TEST(Oscillates, MeasuresFrequencyAndWantsItAllTheTime) {
  Expectation e = Of(Kind::kOscillates);
  e.peak_to_peak = 0.02;
  e.lowest_hz = 99.0;
  e.highest_hz = 101.0;
  EXPECT_EQ(Judge(e, Sine(0.011, 100.0)).outcome, Outcome::kPass);
  EXPECT_NEAR(*Judge(e, Sine(0.011, 100.0)).measured, 0.022, 1e-4) << "sampled every 0.1 ms";
  EXPECT_EQ(Judge(e, Sine(0.0099, 100.0)).outcome, Outcome::kFail) << "too small";
  EXPECT_EQ(Judge(e, Sine(0.011, 103.0)).outcome, Outcome::kFail) << "too fast";
  EXPECT_EQ(Judge(e, Sine(0.011, 100.0, 2'400)).outcome, Outcome::kFail) << "calm for more than a quarter";
  EXPECT_EQ(Judge(e, Spike(2'000, 9.0)).outcome, Outcome::kFail) << "one swing is none";
}

TEST(ModeBecomes, CountsFromItsEvent) {
  Expectation e = Of(Kind::kModeBecomes);
  e.quantity = nullptr;
  e.mode = simulation::Mode::kModelFault;
  e.to_tick = 1'500;
  Course run;
  run.model_fault_at = 1'400;
  EXPECT_DOUBLE_EQ(*Judge(e, run).measured, 40.0) << "ms";
  run.model_fault_at = 1'501;
  EXPECT_EQ(Judge(e, run).outcome, Outcome::kFail) << "too late";
  run.model_fault_at = 900;
  EXPECT_EQ(Judge(e, run).outcome, Outcome::kFail) << "it was so before: it did not become so";
}

}  // namespace
}  // namespace servohil::scenario
