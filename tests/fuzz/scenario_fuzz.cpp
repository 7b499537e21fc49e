// Any bytes as a scenario: read, or refused with one line; the keys that it sets are read as a configuration.

#include "configuration/configuration.hpp"
#include "control/requests.hpp"
#include "fuzz.hpp"
#include "memory_file.hpp"
#include "scenario/reader.hpp"

namespace {

const servohil::fault_words::Permissions& Everything() {
  static const servohil::configuration::Configuration configuration =
      servohil::configuration::LoadConfiguration(SERVOHIL_CONFIG_DIR "/servohil.toml", {});
  static const servohil::signal_map::SignalMap signal_map(configuration);
  static const servohil::fault_words::Permissions permissions{
      {{&configuration.model}, &signal_map}, true, {}};
  return permissions;
}

void RequireSound(const servohil::scenario::Scenario& read) {
  Require(read.duration_ticks > 0 && !read.expectations.empty(), "it lasts, and expects something");
  for (const servohil::scenario::Expectation& one : read.expectations)
    Require(one.from_tick < one.to_tick && one.to_tick <= read.duration_ticks,
            "an expectation lies within it");
  for (std::size_t i = 1; i < read.faults.size(); ++i)
    Require(read.faults[i - 1].tick <= read.faults[i].tick, "faults are in the order of time");
}

}  // namespace

int FuzzOne(std::string_view text) {
  static const MemoryFile file;
  RequireReadableErrors([&] {
    const servohil::scenario::ScenarioFile read(file.With(text));
    if (const auto settings = read.Settings(); !settings.empty())
      servohil::configuration::ParseConfiguration("", SERVOHIL_CONFIG_DIR "/fuzz.toml", {}, settings);
    read.ConfigurationFile();
    RequireSound(read.Understand(Everything()));
  });
  return 0;
}
