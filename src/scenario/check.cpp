#include "scenario/check.hpp"

#include "scenario/mode_check.hpp"
#include "scenario/oscillation_check.hpp"
#include "scenario/range_check.hpp"

namespace servohil::scenario {

const char* NameOf(Outcome outcome) {
  return outcome == Outcome::kPass ? "PASS" : outcome == Outcome::kFail ? "FAIL" : "INVALID";
}

std::unique_ptr<Check> CheckOf(const Expectation& expectation) {
  switch (expectation.kind) {
    case Expectation::Kind::kCalm:
      return std::make_unique<CalmCheck>(expectation);
    case Expectation::Kind::kOscillates:
      return std::make_unique<OscillationCheck>(expectation);
    case Expectation::Kind::kModeBecomes:
    case Expectation::Kind::kModeNever:
      return std::make_unique<ModeCheck>(expectation);
    default:
      return std::make_unique<RangeCheck>(expectation);
  }
}

}  // namespace servohil::scenario
