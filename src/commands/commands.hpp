#pragma once
/// The subcommands. Each adds itself to the command line and leaves its exit status in `exit_status`.

#include "configuration/source.hpp"

namespace CLI {
class App;  // takes seconds to read: only where options are defined
}

namespace servohil::commands {

void AddCheckCommand(CLI::App& program, int& exit_status);
void AddFaultCommand(CLI::App& program, int& exit_status);
void AddLinearCommand(CLI::App& program, int& exit_status);
void AddReplayCommand(CLI::App& program, int& exit_status);
void AddRunCommand(CLI::App& program, int& exit_status);
void AddSimulateCommand(CLI::App& program, int& exit_status);
void AddStatusCommand(CLI::App& program, int& exit_status);
void AddDbcCommand(CLI::App& program, int& exit_status);
void AddSteadyCommand(CLI::App& program, int& exit_status);
void AddThesisCommand(CLI::App& program, int& exit_status);

/// Adds -c, --set and --help-keys.
void AddOptions(CLI::App& command, configuration::ConfigurationOptions& options);

}  // namespace servohil::commands
