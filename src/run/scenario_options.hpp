#pragma once
/// The scenario of a run and its reports.

#include <filesystem>
#include <memory>

#include "configuration/source.hpp"
#include "scenario/evaluation.hpp"
#include "scenario/reader.hpp"

namespace servohil::run {

struct ScenarioOptions {
  std::filesystem::path file;  ///< empty: there is none
  std::filesystem::path json;
  std::filesystem::path junit;

  /// Null where there is none.
  std::unique_ptr<scenario::ScenarioFile> Open() const;

  /// Tells what it came to: on standard output, and in the files. @return exit status
  int Report(const scenario::Scenario& scenario, const scenario::Verdict& verdict) const;
};

/// The configuration for a run with a scenario, or without (null): the scenario's keys count more than a
/// file's, those of the command line count most.
configuration::Configuration LoadFor(const scenario::ScenarioFile* scenario,
                                     const configuration::ConfigurationOptions& options);

}  // namespace servohil::run
