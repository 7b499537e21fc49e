#include "scenario_options.hpp"

#include <iostream>

#include "scenario/report.hpp"
#include "servohil/exit_status.hpp"

namespace servohil::app {

std::unique_ptr<scenario::ScenarioFile> ScenarioOptions::Open() const {
  return file.empty() ? nullptr : std::make_unique<scenario::ScenarioFile>(file);
}

int ScenarioOptions::Report(const scenario::Scenario& scenario, const scenario::Verdict& verdict) const {
  std::cout << ReportText(scenario, verdict) << std::flush;
  if (!json.empty()) scenario::WriteReport(json, ReportJson(scenario, verdict));
  if (!junit.empty()) scenario::WriteReport(junit, ReportJunit(scenario, verdict));
  switch (verdict.Total()) {
    case scenario::Outcome::kPass:
      return kExitOk;
    case scenario::Outcome::kFail:
      return kExitFail;
    default:
      return kExitInvalid;
  }
}

Configuration LoadFor(const scenario::ScenarioFile* scenario, const ConfigurationOptions& options) {
  if (scenario == nullptr) return options.Load();
  std::filesystem::path file = options.file;
  if (const auto own = scenario->ConfigurationFile(); own && file.empty()) file = *own;
  return LoadConfiguration(file, options.settings, scenario->Settings());
}

}  // namespace servohil::app
