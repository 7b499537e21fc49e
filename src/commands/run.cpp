#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <optional>

#include "base/error.hpp"
#include "commands/run_options.hpp"
#include "configuration/envelope_check.hpp"
#include "run/check_configuration.hpp"
#include "run/fast.hpp"
#include "run/log.hpp"
#include "run/on_bus.hpp"
#include "run/snapshot_file.hpp"
#include "run/stop_signals.hpp"

namespace servohil::commands {
namespace {

int Run(const run::RunOptions& options) {
  if (!options.scenario.file.empty() && options.clock == emulator::Clock::kFast)
    throw base::UsageError("run: --clock fast has no bus; `servohil simulate --scenario FILE` is that");
  if (!options.script.empty() && options.clock != emulator::Clock::kFast)
    throw base::UsageError("run: --script is for --clock fast; on a bus the governor gives the commands");
  const run::StopSignals signals;
  run::SetUpLog();
  std::optional<emulator::Snapshot> from;
  run::RunOptions effective = options;
  std::optional<configuration::TemporaryConfiguration> configuration;
  if (!options.from.empty()) {
    run::SnapshotFile file = run::ReadSnapshot(options.from);
    from = file.snapshot;
    configuration.emplace(file.texts);
    effective.configuration.file = configuration->File();
  }
  if (options.check_configuration) return run::CheckConfiguration(effective.configuration, effective.buses);
  const run::RunSetup setup(effective);
  if (const std::string warning = configuration::CheckEnvelope(setup.configuration, setup.derived);
      !warning.empty())
    spdlog::warn("{}", warning);
  return effective.clock == emulator::Clock::kFast ? run::RunFast(effective, setup, from, signals)
                                                   : run::RunOnBus(effective, setup, from, signals);
}

}  // namespace

void AddRunCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<run::RunOptions>();
  CLI::App& command = *program.add_subcommand(
      "run", "Runs the emulator on a CAN bus: in real time, or in lockstep with the governor");
  AddOptions(command, *options);
  command.callback([options, &exit_status] { exit_status = Run(*options); });
}

}  // namespace servohil::commands
