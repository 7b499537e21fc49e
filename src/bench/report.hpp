#pragma once
/// `servohil check` for people and for programs.

#include <string>

#include "bench/findings.hpp"
#include "bench/measurement.hpp"
#include "bench/verdict.hpp"

namespace servohil::bench {

struct Report {
  Findings findings;
  Measurement measurement;
  configuration::LoopSettings loop;
  Verdict verdict;
};

std::string AsText(const Report& report);
/// Keys carry their units.
std::string AsJson(const Report& report);

}  // namespace servohil::bench
