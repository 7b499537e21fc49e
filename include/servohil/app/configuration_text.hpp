#pragma once
/// The effective configuration as a configuration file.

#include <string>

#include "servohil/app/configuration.hpp"

namespace servohil::app {

/// Names of the files that ConfigurationToml() refers to, beside the configuration file.
inline constexpr const char* kLoadFileName = "load_curve.csv";
inline constexpr const char* kLoadClosingFileName = "load_closing.csv";
inline constexpr const char* kDbcFileName = "servohil.dbc";

/// Every key with its value, numbers so that they are read back bit for bit. The files that it names are
/// kLoadFileName, kLoadClosingFileName (where there is one) and kDbcFileName.
std::string ConfigurationToml(const Configuration& configuration);

}  // namespace servohil::app
