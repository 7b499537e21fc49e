#include <nlohmann/json.hpp>

#include "base/formatted.hpp"
#include "model/ticks.hpp"
#include "scenario/report.hpp"

namespace servohil::scenario {

std::string ReportJson(const Scenario& scenario, const Verdict& verdict) {
  using Json = nlohmann::ordered_json;
  Json expectations = Json::array();
  for (const auto& [expectation, finding] : verdict.judgements) {
    expectations.push_back({{"expectation", TextOf(*expectation)},
                            {"line", expectation->line},
                            {"verdict", NameOf(finding.outcome)},
                            {"found", finding.text},
                            {"measured", finding.measured ? Json(*finding.measured) : Json(nullptr)},
                            {"at_s", finding.tick ? Json(model::SecondsOf(*finding.tick)) : Json(nullptr)}});
  }
  const Json report = {{"scenario", scenario.file.string()},
                       {"about", scenario.about},
                       {"verdict", NameOf(verdict.Total())},
                       {"invalid_because", verdict.invalid_because},
                       {"duration_s", model::SecondsOf(verdict.ticks)},
                       {"state_hash", base::HashText(verdict.state_hash)},
                       {"expectations", expectations}};
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace servohil::scenario
