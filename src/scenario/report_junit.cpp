#include "base/formatted.hpp"
#include "model/ticks.hpp"
#include "scenario/report.hpp"

namespace servohil::scenario {
namespace {

std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < ' ' ? ' ' : c;  // XML has no control characters
    }
  }
  return escaped;
}

std::string Reasons(const Verdict& verdict) {
  std::string text;
  for (const std::string& reason : verdict.invalid_because) text += (text.empty() ? "" : "; ") + reason;
  return text;
}

std::string TestCase(const Scenario& scenario, const Verdict& verdict, const Judgement& judgement) {
  const auto& [expectation, finding] = judgement;
  const std::string head = "  <testcase classname=\"" + Escaped(scenario.file.stem().string()) +
                           "\" name=\"" + Escaped(TextOf(*expectation)) + "\" file=\"" +
                           Escaped(scenario.file.string()) + "\" line=\"" +
                           std::to_string(expectation->line) + "\"";
  if (finding.outcome == Outcome::kPass)
    return head + "><system-out>" + Escaped(finding.text) + "</system-out></testcase>\n";
  const std::string what = finding.outcome == Outcome::kFail ? "failure" : "error";
  const std::string why =
      verdict.invalid_because.empty() ? finding.text : "INVALID: " + Reasons(verdict) + "; " + finding.text;
  return head + "><" + what + " message=\"" + Escaped(why) + "\"/></testcase>\n";
}

}  // namespace

std::string ReportJunit(const Scenario& scenario, const Verdict& verdict) {
  std::size_t failures = 0;
  std::size_t errors = 0;
  std::string cases;
  for (const Judgement& judgement : verdict.judgements) {
    failures += judgement.finding.outcome == Outcome::kFail ? 1 : 0;
    errors += judgement.finding.outcome == Outcome::kInvalid ? 1 : 0;
    cases += TestCase(scenario, verdict, judgement);
  }
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites><testsuite name=\"" +
         Escaped(scenario.file.stem().string()) + "\"" +
         base::Formatted(" tests=\"%zu\" failures=\"%zu\" errors=\"%zu\" time=\"%.4f\">\n",
                         verdict.judgements.size(), failures, errors, model::SecondsOf(verdict.ticks)) +
         cases + "</testsuite></testsuites>\n";
}

}  // namespace servohil::scenario
