#include "fault_reader.hpp"

#include "configuration/toml_text.hpp"
#include "servohil/app/ticks.hpp"
#include "servohil/error.hpp"

namespace servohil::app::scenario {
namespace {

/// Ends the reading: the mistake stands at the line of the key that `reason` begins with, if it names one.
[[noreturn]] void Refuse(const Entry& entry, const std::string& reason) {
  for (const auto& [name, node] : entry.Table()) {
    const std::string key(name.str());
    if (reason.rfind(key + " = ", 0) == 0) entry.Fail(key, reason.substr(reason.find(": ") + 2));
  }
  entry.FailWhole(reason);
}

/// What `ask` returns; what it refuses is a mistake of the entry.
template <typename Ask>
auto Permitted(const Entry& entry, Ask ask) {
  try {
    return ask();
  } catch (const UsageError& error) {
    Refuse(entry, error.what());
  } catch (const FaultUnsupported& unsupported) {
    Refuse(entry, unsupported.what());
  }
}

/// All keys but those of the entry itself, in the order of their names.
Words WordsOf(const Entry& entry) {
  Words words;
  for (const auto& [name, node] : entry.Table()) {
    const std::string key(name.str());
    if (key == "name" || key == "at_s") continue;
    if (const auto whole = node.value_exact<std::int64_t>()) {
      words.emplace_back(key, static_cast<double>(*whole));
    } else if (const auto number = node.value_exact<double>()) {
      words.emplace_back(key, *number);
    } else if (const auto text = node.value_exact<std::string>()) {
      words.emplace_back(key, *text);
    } else {
      entry.Fail(key, "must be a number or a text");
    }
  }
  return words;
}

}  // namespace

std::uint64_t FaultTick(Entry& entry, std::uint64_t duration_ticks) {
  return TicksOf(entry.Number("at_s", 0.0, SecondsOf(duration_ticks), "s").value_or(0.0));
}

Influence ReadFault(Entry& entry, std::uint64_t duration_ticks, const Permissions& permissions) {
  const std::string name = entry.RequireText("name");
  const Words words = WordsOf(entry);
  const std::uint64_t after_ticks = FaultTick(entry, duration_ticks);
  const PermittedInjection permitted =
      Permitted(entry, [&] { return RequestInjection(name, words, permissions); });
  if (!permitted.warning.empty()) entry.FailWhole(permitted.warning);  // a fault without effect tests nothing
  return {after_ticks + 1, permitted.request};
}

Influence ReadClear(Entry& entry, std::uint64_t duration_ticks, const Permissions& permissions) {
  const std::optional<std::string> fault = entry.Text("fault");
  const std::uint64_t after_ticks = FaultTick(entry, duration_ticks);
  entry.RefuseOthers();
  return {after_ticks + 1, Permitted(entry, [&] { return RequestClear(fault, {}, permissions); })};
}

}  // namespace servohil::app::scenario
