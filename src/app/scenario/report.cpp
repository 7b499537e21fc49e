#include "report.hpp"

#include <fstream>

#include "formatted.hpp"
#include "servohil/app/ticks.hpp"
#include "servohil/error.hpp"

namespace servohil::app::scenario {
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
    text += Formatted("%-8s ", NameOf(finding.outcome)) + TextOf(*expectation) + ": " + finding.text +
            (pass ? "" : " (" + PlaceOf(scenario, *expectation) + ")") + '\n';
  }
  for (const std::string& reason : verdict.invalid_because)
    text += "INVALID  the whole run: " + reason + '\n';
  return text +
         Formatted("verdict  %s: %zu of %zu expectations hold; %.4f s, hash ", NameOf(verdict.Total()),
                   passed, verdict.judgements.size(), SecondsOf(verdict.ticks)) +
         HashText(verdict.state_hash) + '\n';
}

void WriteReport(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  out.close();
  if (!out) throw EnvironmentError(file.string() + ": the report cannot be written");
}

}  // namespace servohil::app::scenario
