#pragma once
/// What a scenario came to, for people and machines.

#include <filesystem>
#include <string>

#include "scenario/evaluation.hpp"

namespace servohil::scenario {

/// One line per expectation, and the total: "PASS     x3 within ...: ...".
std::string ReportText(const Scenario& scenario, const Verdict& verdict);
std::string ReportJson(const Scenario& scenario, const Verdict& verdict);
/// JUnit XML: an expectation is a test; FAIL a failure, INVALID an error.
std::string ReportJunit(const Scenario& scenario, const Verdict& verdict);

/// @throws EnvironmentError where the file cannot be written
void WriteReport(const std::filesystem::path& file, const std::string& text);

}  // namespace servohil::scenario
