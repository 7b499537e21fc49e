#include "scenario/evaluation.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "base/formatted.hpp"
#include "model/ticks.hpp"

namespace servohil::scenario {
namespace {

double ValueOf(const recording::SampleColumn* quantity, simulation::RunState& now) {
  if (quantity == nullptr) return 0.0;
  return std::visit([&](auto place) { return static_cast<double>(place(now)); }, quantity->place);
}

}  // namespace

Outcome Verdict::Total() const {
  const auto any = [this](Outcome outcome) {
    return std::any_of(judgements.begin(), judgements.end(),
                       [&](const Judgement& judgement) { return judgement.finding.outcome == outcome; });
  };
  if (!invalid_because.empty()) return Outcome::kInvalid;
  return any(Outcome::kFail) ? Outcome::kFail : any(Outcome::kInvalid) ? Outcome::kInvalid : Outcome::kPass;
}

Evaluation::Evaluation(const Scenario& scenario) : duration_ticks_(scenario.duration_ticks) {
  for (const Expectation& expectation : scenario.expectations)
    checks_.push_back({&expectation, CheckOf(expectation)});
}

void Evaluation::Take(const simulation::RunState& run_state) {
  if (!run_state.status.commanded) {
    unresolved_before_ = run_state.sample.unresolved_ticks;
    return;
  }
  simulation::RunState now = run_state;
  if (!begin_tick_) begin_tick_ = now.sample.tick - 1;
  const std::uint64_t tick = now.sample.tick - *begin_tick_;
  if (tick > duration_ticks_) return;
  missing_ += tick - tick_ - 1;
  tick_ = tick;
  unresolved_ = now.sample.unresolved_ticks - unresolved_before_;
  state_hash_ = now.sample.state_hash;
  // After a model fault the state is the last good one: nothing can be told of it.
  if (!now.sample.model_fault) state_tick_ = tick;
  for (const Judged& judged : checks_) {
    const bool of_mode = judged.expectation->quantity == nullptr;
    if (of_mode || !now.sample.model_fault)
      judged.check->Take(tick, ValueOf(judged.expectation->quantity, now), now.status.mode);
  }
}

Finding Evaluation::FindingOf(const Judged& judged) const {
  Finding finding = judged.check->Find();
  const bool of_mode = judged.expectation->quantity == nullptr;
  const std::uint64_t known = of_mode ? tick_ : state_tick_;
  if (finding.decided || known >= judged.expectation->to_tick) return finding;
  finding.outcome = Outcome::kInvalid;
  finding.text = known < tick_ ? "the state left the model's domain"
                               : base::Formatted("the run ended at %.4f s of the scenario, before that",
                                                 model::SecondsOf(tick_));
  return finding;
}

Verdict Evaluation::Judge(std::vector<std::string> invalid_because) const {
  if (!begin_tick_) invalid_because.emplace_back("no command ever came: the governor was not there");
  if (missing_ > 0)
    invalid_because.push_back(base::Formatted("%llu ticks were lost before they were looked at",
                                              static_cast<unsigned long long>(missing_)));
  if (unresolved_ > 0)
    invalid_because.push_back(base::Formatted("%llu ticks were faster than the integration resolves",
                                              static_cast<unsigned long long>(unresolved_)));
  Verdict verdict;
  for (const Judged& judged : checks_) {
    Finding finding = FindingOf(judged);
    if (!invalid_because.empty()) finding.outcome = Outcome::kInvalid;
    verdict.judgements.push_back({judged.expectation, std::move(finding)});
  }
  verdict.invalid_because = std::move(invalid_because);
  verdict.ticks = tick_;
  verdict.state_hash = state_hash_;
  return verdict;
}

}  // namespace servohil::scenario
