#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <memory>
#include <optional>

#include "run/check_configuration.hpp"
#include "run/fast.hpp"
#include "run/log.hpp"
#include "run/on_bus.hpp"
#include "run/snapshot_file.hpp"
#include "run/stop_signals.hpp"
#include "run_options.hpp"
#include "servohil/app/envelope_check.hpp"
#include "servohil/error.hpp"

namespace servohil::app {
namespace {

int Run(const RunOptions& options) {
  if (!options.scenario.file.empty() && options.clock == Clock::kFast)
    throw UsageError("run: --clock fast has no bus; `servohil simulate --scenario FILE` is that");
  if (!options.script.empty() && options.clock != Clock::kFast)
    throw UsageError("run: --script is for --clock fast; on a bus the governor gives the commands");
  const StopSignals signals;
  SetUpLog();
  std::optional<Snapshot> from;
  RunOptions effective = options;
  std::optional<TemporaryConfiguration> configuration;
  if (!options.from.empty()) {
    SnapshotFile file = ReadSnapshot(options.from);
    from = file.snapshot;
    configuration.emplace(file.texts);
    effective.configuration.file = configuration->File();
  }
  if (options.check_configuration) return CheckConfiguration(effective.configuration, effective.buses);
  const RunSetup setup(effective);
  if (const std::string warning = CheckEnvelope(setup.configuration, setup.derived); !warning.empty())
    spdlog::warn("{}", warning);
  return effective.clock == Clock::kFast ? RunFast(effective, setup, from, signals)
                                         : RunOnBus(effective, setup, from, signals);
}

}  // namespace

void AddRunCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<RunOptions>();
  CLI::App& command = *program.add_subcommand(
      "run", "Runs the emulator on a CAN bus: in real time, or in lockstep with the governor");
  AddOptions(command, *options);
  command.callback([options, &exit_status] { exit_status = Run(*options); });
}

}  // namespace servohil::app
