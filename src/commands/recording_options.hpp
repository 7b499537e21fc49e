#pragma once
/// --record and --record-every, for all that runs.

#include "run/recording_options.hpp"

namespace CLI {
class App;
}

namespace servohil::commands {

void AddOptions(CLI::App& command, run::RecordingOptions& options);

}  // namespace servohil::commands
