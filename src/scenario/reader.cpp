#include "scenario/reader.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "base/readable.hpp"
#include "configuration/toml_error.hpp"
#include "configuration/toml_text.hpp"
#include "fault/schedule.hpp"
#include "model/ticks.hpp"
#include "scenario/entry.hpp"
#include "scenario/expectation_reader.hpp"
#include "scenario/fault_reader.hpp"

namespace servohil::scenario {
namespace {

constexpr double kMaxSeconds = 1e6;
constexpr double kMaxP1Psi = 300.0;
constexpr double kMaxP1ChangePsi = 1000.0;

void ReadSettings(const toml::table& table, const std::string& prefix, const std::filesystem::path& file,
                  std::vector<configuration::KeySetting>& settings) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    if (const toml::table* inner = node.as_table()) {
      ReadSettings(*inner, key + ".", file, settings);
    } else if (key != "file") {
      settings.push_back({key, configuration::AsToml(node),
                          file.string() + ":" + std::to_string(node.source().begin.line),
                          file.parent_path()});
    }
  }
}

CommandStep ReadCommand(Entry& entry, double duration_s) {
  CommandStep step;
  step.at_tick = model::TicksOf(entry.RequireNumber("at_s", 0.0, duration_s, "s"));
  const auto p1_psi = entry.Number("p1_psi", 0.0, kMaxP1Psi, "psi");
  const auto change_psi = entry.Number("p1_change_psi", -kMaxP1ChangePsi, kMaxP1ChangePsi, "psi");
  if (p1_psi && change_psi) entry.Fail("p1_change_psi", "must not stand beside p1_psi");
  const auto amplitude_psi = entry.Number("amplitude_psi", 0.0, kMaxP1Psi, "psi");
  if (!p1_psi && !change_psi && !amplitude_psi)
    entry.FailWhole("it commands nothing: give p1_psi, p1_change_psi or amplitude_psi");
  step.is_change = !p1_psi;
  step.p1_psi = p1_psi ? *p1_psi : change_psi.value_or(0.0);
  step.ramp_ticks = model::TicksOf(entry.Number("ramp_s", 0.0, kMaxSeconds, "s").value_or(0.0));
  step.amplitude_psi = amplitude_psi.value_or(0.0);
  if (amplitude_psi) step.frequency_hz = entry.RequireNumber("frequency_hz", 1e-3, 5e3, "Hz");
  if (amplitude_psi && step.ramp_ticks > 0) entry.Fail("ramp_s", "must not stand beside amplitude_psi");
  entry.RefuseOthers();
  return step;
}

}  // namespace

struct ScenarioFile::Contents {
  std::filesystem::path file;
  std::string name;
  toml::table table;

  /// act(entry) for each [[key]] of the file.
  template <typename Act>
  void ForEach(const std::string& key, const Act& act) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return;
    const std::string what = "[[" + key + "]]";
    const toml::array* tables = node->as_array();
    const bool right = tables != nullptr && std::all_of(tables->begin(), tables->end(),
                                                        [](const auto& one) { return one.is_table(); });
    if (!right) {
      throw base::UsageError(name + ":" + std::to_string(node->source().begin.line) + ": " + key +
                             ": must be tables: " + what);
    }
    for (const toml::node& one : *tables) {
      Entry entry(name, what, *one.as_table());
      act(entry);
    }
  }
};

ScenarioFile::ScenarioFile(const std::filesystem::path& file) : contents_(std::make_unique<Contents>()) {
  base::RequireReadable(file);
  contents_->file = file;
  contents_->name = file.string();
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  try {
    contents_->table = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw base::UsageError(configuration::DescribeTomlError(error, text, file.string()));
  }
}

ScenarioFile::~ScenarioFile() = default;

std::optional<std::filesystem::path> ScenarioFile::ConfigurationFile() const {
  const toml::table* table = contents_->table["configuration"].as_table();
  if (table == nullptr || !table->contains("file")) return {};
  Entry entry(contents_->name, "configuration", *table);
  return contents_->file.parent_path() / entry.RequireText("file");
}

std::vector<configuration::KeySetting> ScenarioFile::Settings() const {
  std::vector<configuration::KeySetting> settings;
  if (const toml::table* table = contents_->table["configuration"].as_table())
    ReadSettings(*table, "", contents_->file, settings);
  return settings;
}

Scenario ScenarioFile::Head() const {
  Entry head(contents_->name, "scenario", contents_->table);
  Scenario scenario;
  scenario.file = contents_->file;
  scenario.about = head.Text("about").value_or("");
  scenario.duration_ticks = model::TicksOf(head.RequireNumber("duration_s", model::kTickS, kMaxSeconds, "s"));
  scenario.wait_ticks = model::TicksOf(head.Number("wait_s", model::kTickS, kMaxSeconds, "s").value_or(60.0));
  for (const char* key : {"configuration", "command", "fault", "clear", "expect"}) head.Any(key);
  head.RefuseOthers();
  if (const toml::node* node = contents_->table.get("configuration"); node != nullptr && !node->is_table())
    head.Fail("configuration", "must be a table: [configuration]");
  std::vector<std::pair<std::string, std::uint64_t>> fault_starts;
  contents_->ForEach("fault", [&](Entry& entry) {
    const bool has_trigger = entry.Has("when") || entry.Has("when_frame") || entry.Has("when_fault");
    const std::uint64_t start = FaultTick(entry, scenario.duration_ticks);
    if (!has_trigger) fault_starts.emplace_back(entry.RequireText("name"), start);
  });
  contents_->ForEach("expect", [&](Entry& entry) {
    scenario.expectations.push_back(ReadExpectation(entry, scenario.duration_ticks, fault_starts));
  });
  if (scenario.expectations.empty())
    head.FailWhole("it expects nothing: give at least one [[expect]], e.g. never = \"MODEL_FAULT\"");
  return scenario;
}

Scenario ScenarioFile::UnderstandExpectations() const {
  return Head();
}

Scenario ScenarioFile::Understand(const fault_words::Permissions& permissions) const {
  Scenario scenario = Head();
  contents_->ForEach("command", [&](Entry& entry) {
    scenario.commands.push_back(ReadCommand(entry, model::SecondsOf(scenario.duration_ticks)));
    if (scenario.commands.size() > 1 &&
        scenario.commands.back().at_tick <= scenario.commands[scenario.commands.size() - 2].at_tick)
      entry.Fail("at_s", "must rise from command to command");
  });
  contents_->ForEach("fault", [&](Entry& entry) {
    scenario.faults.push_back(ReadFault(entry, scenario.duration_ticks, permissions));
  });
  contents_->ForEach("clear", [&](Entry& entry) {
    scenario.faults.push_back(ReadClear(entry, scenario.duration_ticks, permissions));
  });
  std::stable_sort(
      scenario.faults.begin(), scenario.faults.end(),
      [](const recording::Stimulus& a, const recording::Stimulus& b) { return a.tick < b.tick; });
  return scenario;
}

}  // namespace servohil::scenario
