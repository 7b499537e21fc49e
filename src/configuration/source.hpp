#pragma once
/// Where a configuration comes from: a file and the keys set on top of it.

#include <filesystem>
#include <string>
#include <vector>

#include "configuration/configuration.hpp"

namespace servohil::configuration {

/// The values of -c and --set, which all subcommands have.
struct ConfigurationOptions {
  std::filesystem::path file;         ///< empty: the default one
  std::vector<std::string> settings;  ///< KEY=VALUE

  /// @throws UsageError as LoadConfiguration
  Configuration Load() const { return LoadConfiguration(file, settings); }
};

}  // namespace servohil::configuration
