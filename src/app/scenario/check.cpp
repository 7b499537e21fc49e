#include "check.hpp"

#include "mode_check.hpp"
#include "oscillation_check.hpp"
#include "range_check.hpp"

namespace servohil::app::scenario {

const char* NameOf(Outcome outcome) {
  return outcome == Outcome::kPass ? "PASS" : outcome == Outcome::kFail ? "FAIL" : "INVALID";
}

std::unique_ptr<Check> CheckOf(const Expectation& expectation) {
  using Kind = Expectation::Kind;
  switch (expectation.kind) {
    case Kind::kCalm:
      return std::make_unique<CalmCheck>(expectation);
    case Kind::kOscillates:
      return std::make_unique<OscillationCheck>(expectation);
    case Kind::kModeBecomes:
    case Kind::kModeNever:
      return std::make_unique<ModeCheck>(expectation);
    default:
      return std::make_unique<RangeCheck>(expectation);
  }
}

}  // namespace servohil::app::scenario
