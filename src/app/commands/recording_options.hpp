#pragma once
/// --record and --record-every, for all that runs.

#include "run/recording_options.hpp"

namespace CLI {
class App;
}

namespace servohil::app {

void AddOptions(CLI::App& command, RecordingOptions& options);

}  // namespace servohil::app
