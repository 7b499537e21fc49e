#pragma once
/// The effective configuration as a configuration file.

#include <cstddef>
#include <string>

#include "configuration/configuration.hpp"

namespace servohil::configuration {

/// Names of the files that ConfigurationToml() refers to, beside the configuration file.
inline constexpr const char* kLoadFileName = "load_curve.csv";
inline constexpr const char* kLoadClosingFileName = "load_closing.csv";
/// "servohil.dbc", "servohil-2.dbc", ...
std::string DbcFileName(std::size_t index);

/// The value of a key as TOML: numbers so that they are read back bit for bit.
std::string ValueToml(const Key& key, Configuration& configuration);

/// Every key with its value, numbers so that they are read back bit for bit. The files that it names are
/// kLoadFileName, kLoadClosingFileName (where there is one) and DbcFileName().
std::string ConfigurationToml(const Configuration& configuration);

}  // namespace servohil::configuration
