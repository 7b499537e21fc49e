#include "run/scenario_options.hpp"

#include <iostream>

#include "base/exit_status.hpp"
#include "scenario/report.hpp"

namespace servohil::run {

std::unique_ptr<scenario::ScenarioFile> ScenarioOptions::Open() const {
  return file.empty() ? nullptr : std::make_unique<scenario::ScenarioFile>(file);
}

int ScenarioOptions::Report(const scenario::Scenario& scenario, const scenario::Verdict& verdict) const {
  std::cout << scenario::ReportText(scenario, verdict) << std::flush;
  if (!json.empty()) scenario::WriteReport(json, scenario::ReportJson(scenario, verdict));
  if (!junit.empty()) scenario::WriteReport(junit, scenario::ReportJunit(scenario, verdict));
  switch (verdict.Total()) {
    case scenario::Outcome::kPass:
      return base::kExitOk;
    case scenario::Outcome::kFail:
      return base::kExitFail;
    default:
      return base::kExitInvalid;
  }
}

configuration::Configuration LoadFor(const scenario::ScenarioFile* scenario,
                                     const configuration::ConfigurationOptions& options) {
  if (scenario == nullptr) return options.Load();
  std::filesystem::path file = options.file;
  if (const auto own = scenario->ConfigurationFile(); own && file.empty()) file = *own;
  return configuration::LoadConfiguration(file, options.settings, scenario->Settings());
}

}  // namespace servohil::run
