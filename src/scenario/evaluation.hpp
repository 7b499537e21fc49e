#pragma once
/// A scenario's expectations held against a run, tick by tick: the same verdict in real time, in lockstep, in
/// `simulate` and in replay.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenario/check.hpp"
#include "scenario/scenario.hpp"
#include "simulation/run_state.hpp"

namespace servohil::scenario {

struct Judgement {
  const Expectation* expectation = nullptr;
  Finding finding;
};

/// What became of a scenario.
struct Verdict {
  std::vector<Judgement> judgements;
  std::vector<std::string> invalid_because;  ///< the whole run is worth nothing
  std::uint64_t ticks = 0;                   ///< of scenario time
  std::uint64_t state_hash = 0;

  /// FAIL where one failed, else INVALID where one is, else PASS.
  Outcome Total() const;
};

/// One thread.
class Evaluation {
 public:
  /// @param scenario  must outlive it
  explicit Evaluation(const Scenario& scenario);

  /// Each tick of the run, in order.
  void Take(const simulation::RunState& now);

  /// At the end. @param invalid_because  what makes the run as a whole worth nothing; the evaluation adds
  /// what
  ///   it has seen itself: no command, ticks that are missing or were not resolved
  Verdict Judge(std::vector<std::string> invalid_because) const;

 private:
  struct Judged {
    const Expectation* expectation;
    std::unique_ptr<Check> check;
  };
  Finding FindingOf(const Judged& judged) const;

  std::vector<Judged> checks_;
  std::uint64_t duration_ticks_;
  std::optional<std::uint64_t> begin_tick_;  ///< of the run, at which scenario time is 0
  std::uint64_t tick_ = 0;                   ///< of scenario time, up to which it is known what happened
  std::uint64_t state_tick_ = 0;             ///< up to which the model was in its domain
  std::uint64_t missing_ = 0;
  std::uint64_t unresolved_before_ = 0;
  std::uint64_t unresolved_ = 0;
  std::uint64_t state_hash_ = 0;
};

}  // namespace servohil::scenario
