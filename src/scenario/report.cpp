#include "scenario/report.hpp"

#include <fstream>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "model/ticks.hpp"

namespace servohil::scenario {
namespace {

std::string PlaceOf(const Scenario& scenario, const Expectation& expectation) {
  return scenario.file.string() + ":" + std::to_string(expectation.line);
}

}  // namespace

std::string ReportText(const Scenario& scenario, const Verdict& verdict) {
  std::string text =
      "scenario " + scenario.file.string() + (scenario.about.empty() ? "" : ": " + scenario.about) + '\n';
  std::size_t passed = 0;
  for (const auto& [expectation, finding] : verdict.judgements) {
    const bool pass = finding.outcome == Outcome::kPass;
    passed += pass ? 1 : 0;
    text += base::Formatted("%-8s ", NameOf(finding.outcome)) + TextOf(*expectation) + ": " + finding.text +
            (pass ? "" : " (" + PlaceOf(scenario, *expectation) + ")") + '\n';
  }
  for (const std::string& reason : verdict.invalid_because)
    text += "INVALID  the whole run: " + reason + '\n';
  return text +
         base::Formatted("verdict  %s: %zu of %zu expectations hold; %.4f s, hash ", NameOf(verdict.Total()),
                         passed, verdict.judgements.size(), model::SecondsOf(verdict.ticks)) +
         base::HashText(verdict.state_hash) + '\n';
}

void WriteReport(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out) throw base::EnvironmentError(file.string() + ": the report cannot be written");
}

}  // namespace servohil::scenario
