#include "requests.hpp"
#include "servohil/app/ticks.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "../formatted.hpp"
#include "servohil/model/step.hpp"
#include "servohil/nearest_name.hpp"

namespace servohil::app::control {
namespace {

using Json = nlohmann::json;

constexpr double kMostSeconds = 1e6;

/// Ends the understanding of a request: its answer.
struct Refusal {
  Json answer;
};

[[noreturn]] void Reject(const std::string& reason) {
  throw Refusal{Rejected(reason)};
}

std::string Nearest(const std::string& name, const std::vector<std::string>& names) {
  const std::string nearest = NearestName(name, names);
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

const fault::Spec& RequireFault(const Json& request) {
  const auto name = request.find("fault");
  if (name == request.end() || !name->is_string()) Reject("\"fault\" must name a fault");
  std::vector<std::string> names;
  for (const fault::Spec& spec : fault::Catalogue()) {
    if (*name == spec.name) return spec;
    names.emplace_back(spec.name);
  }
  const std::string asked = *name;
  Reject("there is no fault " + asked.substr(0, 60) + Nearest(asked, names));
}

double RequireNumber(const std::string& name, const Json& value, double minimum, double maximum,
                     const std::string& unit) {
  if (!value.is_number() || !(value.get<double>() >= minimum && value.get<double>() <= maximum)) {
    Reject(Formatted("%s = %s: must be a number from %g to %g%s%s", name.substr(0, 40).c_str(),
                     value.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 40).c_str(),
                     minimum, maximum, unit.empty() ? "" : " ", unit.c_str()));
  }
  return value.get<double>();
}

/// The time line's own parameters, which every fault has.
bool SetTiming(const std::string& name, const Json& value, fault::Injection& injection) {
  const auto ticks = [&] { return TicksOf(RequireNumber(name, value, 0.0, kMostSeconds, "s")); };
  if (name == "at_s") {
    injection.start_tick = ticks() + 1;
  } else if (name == "ramp_s") {
    injection.ramp_ticks = ticks();
  } else if (name == "for_s") {
    injection.for_ticks = std::max<std::uint64_t>(1, ticks());
  } else {
    return false;
  }
  return true;
}

void SetParameter(const fault::Spec& spec, const std::string& name, const Json& value,
                  fault::Injection& injection) {
  std::vector<std::string> names = {"at_s", "ramp_s", "for_s"};
  for (std::size_t i = 0; i < spec.parameters.size() && spec.parameters[i].name != nullptr; ++i) {
    const fault::ParameterSpec& p = spec.parameters[i];
    if (name == p.name) {
      injection.values[i] = RequireNumber(name, value, p.minimum, p.maximum, p.unit);
      return;
    }
    names.insert(names.begin(), p.name);
  }
  std::string all;
  for (const std::string& one : names) all += (all.empty() ? "" : ", ") + one;
  const std::string nearest = Nearest(name, names);
  Reject(std::string(spec.name) + " has no parameter " + name.substr(0, 40) +
         (nearest.empty() ? "; it has " + all : nearest));
}

Request UnderstandInject(const Json& request, const Permissions& permissions) {
  const fault::Spec& spec = RequireFault(request);
  if (!permissions.armed) Reject(permissions.why_not_armed);
  if (const char* why = fault::Unsupported(spec, *permissions.unfaulted))
    throw Refusal{{{"result", "UNSUPPORTED"}, {"reason", std::string(spec.name) + ": " + why}}};
  Request understood;
  understood.kind = Request::Kind::kInject;
  understood.injection.id = spec.id;
  for (std::size_t i = 0; i < spec.parameters.size(); ++i)
    understood.injection.values[i] = spec.parameters[i].preset;
  const Json parameters = request.value("parameters", Json::object());
  if (!parameters.is_object()) Reject("\"parameters\" must be an object: {\"NAME\": NUMBER, ...}");
  for (const auto& [name, value] : parameters.items()) {
    if (!SetTiming(name, value, understood.injection)) SetParameter(spec, name, value, understood.injection);
  }
  return understood;
}

Request UnderstandClear(const Json& request) {
  Request understood;
  understood.kind = Request::Kind::kClearAll;
  if (!request.contains("fault") || request["fault"].is_null()) return understood;
  understood.kind = Request::Kind::kClear;
  understood.injection.id = RequireFault(request).id;
  return understood;
}

Request UnderstandCommand(const Json& request) {
  Request understood;
  understood.kind = Request::Kind::kCommand;
  if (!request.contains("p1_psi")) Reject("\"p1_psi\" is missing");
  understood.p1_psi = RequireNumber("p1_psi", request["p1_psi"], 0.0, 300.0, "psi");
  return understood;
}

Understood UnderstandOrThrow(const Json& request, const Permissions& permissions) {
  if (!request.is_object()) Reject("a request is a JSON object");
  const auto what = request.find("request");
  if (what == request.end() || !what->is_string()) Reject("\"request\" is missing");
  if (*what == "inject") return UnderstandInject(request, permissions);
  if (*what == "clear") return UnderstandClear(request);
  if (*what == "command") return UnderstandCommand(request);
  if (*what == "snapshot") {
    Request understood;
    understood.kind = Request::Kind::kSnapshot;
    return understood;
  }
  if (*what == "status") return Question::kStatus;
  if (*what == "faults") return Question::kFaults;
  if (*what == "catalogue") return Question::kCatalogue;
  const std::vector<std::string> names = {"inject", "clear",   "faults",  "catalogue",
                                          "status", "command", "snapshot"};
  const std::string asked = *what;
  const std::string nearest = Nearest(asked, names);
  Reject("there is no request " + asked.substr(0, 40) +
         (nearest.empty() ? "; there are inject, clear, faults, catalogue, status, command, snapshot"
                          : nearest));
}

/// JSON as one line of valid UTF-8, whatever texts it has.
std::string OneLine(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Understood UnderstandObject(const Json& request, const Permissions& permissions) {
  try {
    return UnderstandOrThrow(request, permissions);
  } catch (const Refusal& refusal) {
    return refusal.answer;
  } catch (const Json::exception& error) {
    return Rejected(error.what());
  }
}

}  // namespace

RequestLine Understand(std::string_view line, const Permissions& permissions) {
  const Json request = Json::parse(line, nullptr, false);
  if (request.is_discarded()) return {"null", Rejected("this line is not JSON")};
  const bool has_id = request.is_object() && request.contains("id");
  return {has_id ? OneLine(request["id"]) : "null", UnderstandObject(request, permissions)};
}

std::string AnswerLine(const std::string& id, const Json& answer) {
  return "{\"id\":" + id + "," + OneLine(answer).substr(1) + '\n';
}

Json Rejected(const std::string& reason) {
  return {{"result", "REJECTED"}, {"reason", reason}};
}

Json ToJson(const Answer& answer) {
  switch (answer.result) {
    case Answer::Result::kNoRoom:
      return Rejected(Formatted("%zu faults are as many as there can be at once: clear one",
                                fault::Schedule::kMostInjections));
    case Answer::Result::kNoSuchFault:
      return Rejected("this fault is not injected");
    case Answer::Result::kFrozen:
      return Rejected("simulated time is frozen (loop.overrun = \"freeze\"): nothing acts any more");
    case Answer::Result::kNotFollowed:
      return Rejected("P1 is not followed: tripped, or the model has left its domain");
    default:
      return {{"result", "APPLIED"}, {"tick", answer.tick}};
  }
}

Json FaultsToJson(const fault::Schedule& faults, std::uint64_t tick) {
  Json list = Json::array();
  for (const fault::Injection& injection : faults) {
    if (injection.IsOverAt(tick)) continue;
    const fault::Spec& spec = *fault::Find(injection.id);
    Json parameters = Json::object();
    for (std::size_t i = 0; i < spec.parameters.size() && spec.parameters[i].name != nullptr; ++i)
      parameters[spec.parameters[i].name] = injection.values[i];
    const double t_s = model::kTickS;
    list.push_back(
        {{"fault", spec.name},
         {"parameters", parameters},
         {"share", injection.ShareAt(tick)},
         {"start_tick", injection.start_tick},
         {"ramp_s", static_cast<double>(injection.ramp_ticks) * t_s},
         {"for_s",
          injection.for_ticks == 0 ? Json(nullptr) : Json(static_cast<double>(injection.for_ticks) * t_s)}});
  }
  return {{"result", "OK"}, {"tick", tick}, {"faults", list}};
}

Json CatalogueToJson(const model::Parameters& unfaulted) {
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
    const char* why = fault::Unsupported(spec, unfaulted);
    list.push_back({{"fault", spec.name},
                    {"part", fault::NameOf(spec.part)},
                    {"effect", spec.effect},
                    {"parameters", parameters},
                    {"unsupported", why == nullptr ? Json(nullptr) : Json(why)}});
  }
  return {{"result", "OK"}, {"catalogue", list}};
}

}  // namespace servohil::app::control
