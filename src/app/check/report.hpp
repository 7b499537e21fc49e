#pragma once
/// `servohil check` for people and for programs.

#include <string>

#include "findings.hpp"
#include "measurement.hpp"
#include "verdict.hpp"

namespace servohil::app::check {

struct Report {
  Findings findings;
  Measurement measurement;
  LoopSettings loop;
  Verdict verdict;
};

std::string AsText(const Report& report);
/// Keys carry their units.
std::string AsJson(const Report& report);

}  // namespace servohil::app::check
