#pragma once
/// The subcommands. Each adds itself to the command line and leaves its exit status in `exit_status`.

#include <filesystem>
#include <string>
#include <vector>

#include "servohil/app/configuration.hpp"
#include "servohil/model/derived.hpp"
#include "servohil/model/steady_state.hpp"

namespace CLI {
class App;  // takes seconds to read: only where options are defined
}

namespace servohil::app {

/// Exit statuses of the program.
inline constexpr int kExitOk = 0;
inline constexpr int kExitNotValid = 1;     ///< the run was not valid, or the replay differs
inline constexpr int kExitFail = 1;         ///< of a scenario: something that is expected was not so
inline constexpr int kExitUsage = 2;        ///< usage or configuration
inline constexpr int kExitEnvironment = 3;  ///< the machine lacks something
inline constexpr int kExitInvalid = 4;      ///< of a scenario: the run is worth nothing

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

/// -c and --set, which all subcommands have.
struct ConfigurationOptions {
  std::filesystem::path file;
  std::vector<std::string> settings;

  void AddTo(CLI::App& command);
  Configuration Load() const { return LoadConfiguration(file, settings); }
};

/// Steady state, or a UsageError that says why there is none and what would have one.
model::SteadyState RequireSteadyStateAt(const model::Derived& derived, double x3_in);
model::SteadyState RequireSteadyStateForP1(const model::Derived& derived, double p1_psi);

}  // namespace servohil::app
