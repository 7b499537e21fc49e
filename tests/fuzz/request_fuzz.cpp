// Any line on the control socket: a request within its ranges, or an answer that is one line of JSON.

#include "fuzz.hpp"

#include <cmath>

#include "control/requests.hpp"

namespace {

using servohil::simulation::Request;

/// Armed, on a bus with protected messages.
const servohil::fault_words::Permissions& Everything() {
  static const auto configuration =
      servohil::configuration::LoadConfiguration(SERVOHIL_CONFIG_DIR "/servohil.toml", {});
  static const servohil::signal_map::SignalMap signal_map(configuration);
  static const servohil::fault_words::Permissions permissions{
      {{&configuration.model, true, true, true, true}, &signal_map, signal_map.Wanted()}, true, {}};
  return permissions;
}

void RequireSound(const Request& request) {
  if (request.kind == Request::Kind::kCommand)
    Require(request.p1_psi >= 0.0 && request.p1_psi <= 300.0, "P1 is within its range");
  for (const double value : request.injection.values) Require(std::isfinite(value), "parameters are finite");
}

void RequireOneLineOfJson(const std::string& line) {
  Require(!line.empty() && line.find('\n') == line.size() - 1, "an answer is one line");
  Require(nlohmann::json::parse(line, nullptr, false).is_object(), "an answer is a JSON object");
}

/// What else is said of it: the list of faults, and samples.
void Tell(const servohil::control::RequestLine& understood) {
  if (const Request* request = std::get_if<Request>(&understood.asks);
      request != nullptr && request->kind == Request::Kind::kInject) {
    servohil::fault::Schedule faults;
    faults.Inject(request->injection);
    RequireOneLineOfJson(servohil::control::AnswerLine(
        understood.id, servohil::control::FaultsToJson(faults, 1, Everything().faults)));
  }
  if (const auto* subscription = std::get_if<servohil::control::Subscription>(&understood.asks))
    RequireOneLineOfJson(servohil::control::SampleLine(understood.id, *subscription, {}, 0));
}

}  // namespace

int FuzzOne(std::string_view line) {
  constexpr std::size_t kLongestLine = 4'096;
  if (line.size() > kLongestLine || line.find('\n') != std::string_view::npos) return -1;
  const servohil::control::RequestLine understood = servohil::control::Understand(line, Everything());
  if (const Request* request = std::get_if<Request>(&understood.asks)) RequireSound(*request);
  const nlohmann::json* answer = std::get_if<nlohmann::json>(&understood.asks);
  RequireOneLineOfJson(servohil::control::AnswerLine(
      understood.id, answer != nullptr ? *answer : servohil::control::Rejected("")));
  Tell(understood);
  return 0;
}
