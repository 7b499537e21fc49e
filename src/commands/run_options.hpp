#pragma once
/// The command line of `servohil run`.

#include "run/run_options.hpp"

namespace CLI {
class App;
}

namespace servohil::commands {

/// Adds all options of `servohil run`.
void AddOptions(CLI::App& command, run::RunOptions& options);

}  // namespace servohil::commands
