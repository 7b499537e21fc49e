#include "control/requests.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <vector>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "base/nearest_name.hpp"
#include "model/step.hpp"
#include "model/ticks.hpp"
#include "simulation/quantity.hpp"

namespace servohil::control {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxShown = 60;  // of what somebody else wrote

/// Ends the understanding of a request: its answer.
struct Refusal {
  Json answer;
};

[[noreturn]] void Reject(const std::string& reason) {
  throw Refusal{Rejected(reason)};
}

double RequireNumber(const std::string& name, const Json& value, double minimum, double maximum,
                     const std::string& unit) {
  if (!value.is_number() || !(value.get<double>() >= minimum && value.get<double>() <= maximum)) {
    Reject(base::Formatted("%s = %s: must be a number from %g to %g%s%s", name.substr(0, 40).c_str(),
                           value.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 40).c_str(),
                           minimum, maximum, unit.empty() ? "" : " ", unit.c_str()));
  }
  return value.get<double>();
}

/// The parameters of a fault; what is neither a number nor a text is refused here.
fault_words::Words WordsOf(const Json& request) {
  const Json parameters = request.value("parameters", Json::object());
  if (!parameters.is_object()) Reject("\"parameters\" must be an object: {\"NAME\": NUMBER or TEXT, ...}");
  fault_words::Words words;
  for (const auto& [name, value] : parameters.items()) {
    if (value.is_number()) {
      words.emplace_back(name, value.get<double>());
    } else if (value.is_string()) {
      words.emplace_back(name, value.get<std::string>());
    } else {
      Reject(name.substr(0, kMaxShown) + ": must be a number or a text");
    }
  }
  return words;
}

std::string FaultOf(const Json& request) {
  const auto name = request.find("fault");
  if (name == request.end() || !name->is_string()) Reject("\"fault\" must name a fault");
  return *name;
}

simulation::Request UnderstandInject(const Json& request, const fault_words::Permissions& permissions,
                                     std::string& warning) {
  fault_words::PermittedInjection permitted =
      fault_words::RequestInjection(FaultOf(request), WordsOf(request), permissions);
  warning = std::move(permitted.warning);
  return permitted.request;
}

simulation::Request UnderstandClear(const Json& request, const fault_words::Permissions& permissions) {
  if (!request.contains("fault") || request["fault"].is_null())
    return fault_words::RequestClear({}, {}, permissions);
  return fault_words::RequestClear(FaultOf(request), WordsOf(request), permissions);
}

simulation::Request UnderstandCommand(const Json& request) {
  simulation::Request understood;
  understood.kind = simulation::Request::Kind::kCommand;
  if (!request.contains("p1_psi")) Reject("\"p1_psi\" is missing");
  understood.p1_psi = RequireNumber("p1_psi", request["p1_psi"], 0.0, 300.0, "psi");
  return understood;
}

std::size_t RequireQuantity(const Json& name) {
  std::vector<std::string> names;
  for (const simulation::Quantity& quantity : simulation::Quantities()) {
    if (name == quantity.name) return names.size();
    names.emplace_back(quantity.name);
  }
  if (!name.is_string()) Reject("\"quantities\" must be a list of names: [\"x3_in\", ...]");
  const std::string asked = name;
  Reject("there is no quantity " + asked.substr(0, 40) + "; " +
         base::DidYouMean(asked, names, "PROTOCOL.md lists them, such as x3_in"));
}

Subscription UnderstandSubscribe(const Json& request) {
  constexpr double kMaxMs = 60'000.0;
  if (!request.contains("every_ms")) Reject("\"every_ms\" is missing");
  const double ms = RequireNumber("every_ms", request["every_ms"], 1.0, kMaxMs, "ms");
  Subscription subscription;
  subscription.every_ticks = static_cast<std::uint64_t>(std::llround(ms * model::kTicksPerMs));
  if (!request.contains("quantities")) {
    subscription.quantities.resize(simulation::Quantities().size());
    std::iota(subscription.quantities.begin(), subscription.quantities.end(), std::size_t{0});
    return subscription;
  }
  if (!request["quantities"].is_array()) RequireQuantity(nullptr);
  for (const Json& name : request["quantities"]) {
    const std::size_t quantity = RequireQuantity(name);
    const auto& known = subscription.quantities;
    if (std::find(known.begin(), known.end(), quantity) == known.end())
      subscription.quantities.push_back(quantity);
  }
  return subscription;
}

Understood UnderstandOrThrow(const Json& request, const fault_words::Permissions& permissions,
                             std::string& warning) {
  if (!request.is_object()) Reject("a request is a JSON object");
  const auto what = request.find("request");
  if (what == request.end() || !what->is_string()) Reject("\"request\" is missing");
  if (*what == "inject") return UnderstandInject(request, permissions, warning);
  if (*what == "clear") return UnderstandClear(request, permissions);
  if (*what == "command") return UnderstandCommand(request);
  if (*what == "snapshot") {
    simulation::Request understood;
    understood.kind = simulation::Request::Kind::kSnapshot;
    return understood;
  }
  if (*what == "subscribe") return UnderstandSubscribe(request);
  if (*what == "unsubscribe") return Subscription{};
  if (*what == "status") return Question::kStatus;
  if (*what == "statistics") return Question::kStatistics;
  if (*what == "faults") return Question::kFaults;
  if (*what == "catalogue") return Question::kCatalogue;
  const std::vector<std::string> names = {"inject",  "clear",    "faults",    "catalogue",   "status",
                                          "command", "snapshot", "subscribe", "unsubscribe", "statistics"};
  const std::string asked = *what;
  Reject("there is no request " + asked.substr(0, 40) + "; " +
         base::DidYouMean(asked, names, "there are " + base::Listed(names)));
}

/// JSON as one line of valid UTF-8, whatever texts it has.
std::string OneLine(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Understood UnderstandObject(const Json& request, const fault_words::Permissions& permissions,
                            std::string& warning) {
  try {
    return UnderstandOrThrow(request, permissions, warning);
  } catch (const fault_words::FaultUnsupported& unsupported) {
    return Json{{"result", "UNSUPPORTED"}, {"reason", unsupported.what()}};
  } catch (const base::UsageError& error) {
    return Rejected(error.what());
  } catch (const Refusal& refusal) {
    return refusal.answer;
  } catch (const Json::exception& error) {
    return Rejected(error.what());
  }
}

}  // namespace

RequestLine Understand(std::string_view line, const fault_words::Permissions& permissions) {
  const Json request = Json::parse(line, nullptr, false);
  if (request.is_discarded()) return {"null", Rejected("this line is not JSON")};
  const bool has_id = request.is_object() && request.contains("id");
  RequestLine understood{has_id ? OneLine(request["id"]) : "null", {}, {}};
  understood.asks = UnderstandObject(request, permissions, understood.warning);
  return understood;
}

std::string AnswerLine(const std::string& id, const Json& answer) {
  return "{\"id\":" + id + "," + OneLine(answer).substr(1) + '\n';
}

Json Rejected(const std::string& reason) {
  return {{"result", "REJECTED"}, {"reason", reason}};
}

Json ToJson(const simulation::Answer& answer) {
  switch (answer.result) {
    case simulation::Answer::Result::kNoRoom:
      return Rejected(base::Formatted("%zu faults are as many as there can be at once: clear one",
                                      fault::Schedule::kMaxInjections));
    case simulation::Answer::Result::kNoSuchFault:
      return Rejected("this fault is not injected");
    case simulation::Answer::Result::kNoSnapshot:
      return Rejected("a snapshot cannot hold the past that sensor_delayed needs: clear it first");
    case simulation::Answer::Result::kFrozen:
      return Rejected("simulated time is frozen (loop.overrun = \"freeze\"): nothing acts any more");
    case simulation::Answer::Result::kNotFollowed:
      return Rejected("P1 is not followed: tripped, or the model has left its domain");
    default:
      return {{"result", "APPLIED"}, {"tick", answer.tick}};
  }
}

std::string SampleLine(const std::string& id, const Subscription& subscription,
                       const simulation::RunState& now, std::uint64_t dropped) {
  Json sample = {{"result", "SAMPLE"}, {"time_s", model::SecondsOf(now.sample.tick)}, {"dropped", dropped}};
  for (const std::size_t which : subscription.quantities) {
    const simulation::Quantity& quantity = simulation::Quantities()[which];
    sample[quantity.name] = quantity.value(now);  // infinite: null
  }
  sample["tick"] = now.sample.tick;
  return AnswerLine(id, sample);
}

namespace {

Json InjectionToJson(const fault::Injection& injection, std::uint64_t tick,
                     const fault_words::FaultContext& context) {
  const fault::Spec& spec = *fault::Find(injection.id);
  Json parameters = Json::object();
  for (std::size_t i = 0; i < spec.parameters.size() && spec.parameters[i].name != nullptr; ++i)
    parameters[spec.parameters[i].name] = injection.values[i];
  if (injection.target != fault::Injection::kEverything)
    parameters[spec.HasSignal() ? "signal" : "message"] =
        fault_words::TargetName(spec, injection.target, context.signal_map);
  if (spec.random) parameters["seed"] = injection.seed;
  const auto seconds_or_null = [](std::uint64_t ticks) {
    return ticks == 0 ? Json(nullptr) : Json(model::SecondsOf(ticks));
  };
  const std::string trigger = fault_words::TriggerText(injection.trigger);
  return {{"fault", spec.name},
          {"parameters", parameters},
          {"share", injection.ShareAt(tick)},
          {"waits", injection.waits},
          {"trigger", trigger.empty() ? Json(nullptr) : Json(trigger)},
          {"start_tick", injection.start_tick},
          {"ramp_s", model::SecondsOf(injection.ramp_ticks)},
          {"ramp_out_s", model::SecondsOf(injection.ramp_out_ticks)},
          {"for_s", seconds_or_null(injection.for_ticks)},
          {"every_s", seconds_or_null(injection.period_ticks)},
          {"times", injection.times}};
}

}  // namespace

Json FaultsToJson(const fault::Schedule& faults, std::uint64_t tick,
                  const fault_words::FaultContext& context) {
  Json list = Json::array();
  for (const fault::Injection& injection : faults) {
    if (injection.IsOverAt(tick) && !injection.FiresAgain()) continue;
    list.push_back(InjectionToJson(injection, tick, context));
  }
  return {{"result", "OK"}, {"tick", tick}, {"faults", list}};
}

Json CatalogueToJson(const fault::Surroundings& surroundings) {
  Json list = Json::array();
  for (const fault::Spec& spec : fault::Catalogue()) {
    Json parameters = Json::array();
    for (const fault::ParameterSpec& p : spec.parameters) {
      if (p.name == nullptr) break;
      parameters.push_back({{"name", p.name},
                            {"unit", p.unit},
                            {"minimum", p.minimum},
                            {"maximum", p.maximum},
                            {"default", p.preset},
                            {"meaning", p.meaning}});
    }
    Json common = Json::array();
    for (const fault_words::CommonParameter& p : fault_words::CommonParameters()) {
      if (p.fits(spec)) common.push_back(p.name);
    }
    const char* why = fault::Unsupported(spec, surroundings);
    list.push_back({{"fault", spec.name},
                    {"part", fault::NameOf(spec.part)},
                    {"effect", spec.effect},
                    {"parameters", parameters},
                    {"common", common},
                    {"unsupported", why == nullptr ? Json(nullptr) : Json(why)}});
  }
  return {{"result", "OK"}, {"catalogue", list}};
}

}  // namespace servohil::control
