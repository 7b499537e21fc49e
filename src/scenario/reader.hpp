#pragma once
/// Reads a scenario file. config/scenarios/README.md describes it.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "configuration/configuration.hpp"
#include "fault_words/permissions.hpp"
#include "scenario/scenario.hpp"

namespace servohil::scenario {

/// A scenario file, not yet understood: its faults depend on the model that it configures.
/// Every function throws UsageError: one line with file, line, key, value and what would be right.
class ScenarioFile {
 public:
  explicit ScenarioFile(const std::filesystem::path& file);
  ~ScenarioFile();
  ScenarioFile(const ScenarioFile&) = delete;
  ScenarioFile& operator=(const ScenarioFile&) = delete;

  /// The configuration file that it names; nothing: none.
  std::optional<std::filesystem::path> ConfigurationFile() const;
  /// The keys that it sets.
  std::vector<configuration::KeySetting> Settings() const;

  /// The whole. @param permissions  of whoever runs it: which faults there may be
  Scenario Understand(const fault_words::Permissions& permissions) const;
  /// For a recording: what is expected, without what happens.
  Scenario UnderstandExpectations() const;

 private:
  struct Contents;
  Scenario Head() const;
  std::unique_ptr<Contents> contents_;
};

}  // namespace servohil::scenario
