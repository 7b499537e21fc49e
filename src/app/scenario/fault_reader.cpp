#include "fault_reader.hpp"

#include <nlohmann/json.hpp>

#include "configuration/toml_text.hpp"
#include "servohil/app/ticks.hpp"

namespace servohil::app::scenario {
namespace {

using Json = nlohmann::json;

Json ToJson(const toml::node& node) {
  if (const auto flag = node.value_exact<bool>()) return *flag;
  if (const auto whole = node.value_exact<std::int64_t>()) return *whole;
  if (const auto number = node.value_exact<double>()) return *number;
  if (const auto text = node.value_exact<std::string>()) return *text;
  return Shown(node);
}

/// What the control socket makes of it; its refusal becomes a mistake at the line of the key that it names.
Influence Understood(const Entry& entry, const Json& request, std::uint64_t after_ticks,
                     const control::Permissions& permissions) {
  const control::RequestLine line = control::Understand(request.dump(), permissions);
  if (!line.warning.empty()) entry.FailWhole(line.warning);  // a test with a fault that does nothing is none
  if (const auto* asked = std::get_if<Request>(&line.asks)) return {after_ticks + 1, *asked};
  const std::string reason = std::get<Json>(line.asks).value("reason", "");
  for (const auto& [name, node] : entry.Table()) {
    const std::string key(name.str());
    if (reason.rfind(key + " = ", 0) == 0) entry.Fail(key, reason.substr(reason.find(": ") + 2));
  }
  entry.FailWhole(reason);
}

}  // namespace

std::uint64_t FaultTick(Entry& entry, std::uint64_t duration_ticks) {
  return TicksOf(entry.Number("at_s", 0.0, SecondsOf(duration_ticks), "s").value_or(0.0));
}

Influence ReadFault(Entry& entry, std::uint64_t duration_ticks, const control::Permissions& permissions) {
  Json parameters = Json::object();
  for (const auto& [name, node] : entry.Table()) {
    const std::string key(name.str());
    if (key != "name" && key != "at_s") parameters[key] = ToJson(node);
  }
  const Json request = {
      {"request", "inject"}, {"fault", entry.RequireText("name")}, {"parameters", parameters}};
  return Understood(entry, request, FaultTick(entry, duration_ticks), permissions);
}

Influence ReadClear(Entry& entry, std::uint64_t duration_ticks, const control::Permissions& permissions) {
  Json request = {{"request", "clear"}};
  if (const auto name = entry.Text("fault")) request["fault"] = *name;
  const std::uint64_t after_ticks = FaultTick(entry, duration_ticks);
  entry.RefuseOthers();
  return Understood(entry, request, after_ticks, permissions);
}

}  // namespace servohil::app::scenario
