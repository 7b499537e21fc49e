#include "scenario/fault_reader.hpp"

#include "base/error.hpp"
#include "configuration/toml_text.hpp"
#include "model/ticks.hpp"

namespace servohil::scenario {
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
  } catch (const base::UsageError& error) {
    Refuse(entry, error.what());
  } catch (const fault_words::FaultUnsupported& unsupported) {
    Refuse(entry, unsupported.what());
  }
}

/// All keys but those of the entry itself, in the order of their names.
fault_words::Words WordsOf(const Entry& entry) {
  fault_words::Words words;
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
  return model::TicksOf(entry.Number("at_s", 0.0, model::SecondsOf(duration_ticks), "s").value_or(0.0));
}

recording::Stimulus ReadFault(Entry& entry, std::uint64_t duration_ticks,
                              const fault_words::Permissions& permissions) {
  const std::string name = entry.RequireText("name");
  const fault_words::Words words = WordsOf(entry);
  const std::uint64_t after_ticks = FaultTick(entry, duration_ticks);
  const fault_words::PermittedInjection permitted =
      Permitted(entry, [&] { return fault_words::RequestInjection(name, words, permissions); });
  if (!permitted.warning.empty()) entry.FailWhole(permitted.warning);  // a fault without effect tests nothing
  return {after_ticks + 1, permitted.request};
}

recording::Stimulus ReadClear(Entry& entry, std::uint64_t duration_ticks,
                              const fault_words::Permissions& permissions) {
  const std::optional<std::string> fault = entry.Text("fault");
  const std::uint64_t after_ticks = FaultTick(entry, duration_ticks);
  entry.RefuseOthers();
  return {after_ticks + 1,
          Permitted(entry, [&] { return fault_words::RequestClear(fault, {}, permissions); })};
}

}  // namespace servohil::scenario
