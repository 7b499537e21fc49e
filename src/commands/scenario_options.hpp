#pragma once
/// --scenario and its reports, for all that runs.

#include "run/scenario_options.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace servohil::commands {

/// @return the option --scenario
CLI::Option* AddOptions(CLI::App& command, run::ScenarioOptions& options);

}  // namespace servohil::commands
