#include "run/on_bus.hpp"

#include <spdlog/spdlog.h>

#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "can/network.hpp"
#include "configuration/run_texts.hpp"
#include "control/server.hpp"
#include "run/bus_setup.hpp"
#include "run/bus_watch.hpp"
#include "run/permission.hpp"
#include "run/reload.hpp"
#include "run/report.hpp"
#include "run/scenario_on_bus.hpp"
#include "run/snapshot_writer.hpp"
#include "run/statistics.hpp"
#include "run/watch.hpp"

namespace servohil::run {
namespace {

/// @param path  empty: where nobody has to be told; taken by another run, this one goes without
std::unique_ptr<control::Server> OpenControl(const std::string& path, emulator::Emulator& emulator,
                                             fault_words::Permissions permissions) {
  if (path == "none") return nullptr;
  try {
    auto server = std::make_unique<control::Server>(
        path.empty() ? control::DefaultSocket() : std::filesystem::path(path), emulator,
        std::move(permissions));
    spdlog::info("control socket: {}", server->Path().string());
    return server;
  } catch (const base::EnvironmentError& error) {
    if (!path.empty()) throw;
    spdlog::info("no control socket: {}", error.what());
    return nullptr;
  }
}

emulator::EmulatorOptions EmulatorOptionsOf(const RunOptions& options,
                                            const configuration::Configuration& configuration,
                                            const signal_map::SignalMap& signal_map) {
  emulator::EmulatorOptions emulator;
  emulator.task = TaskOptionsOf(options, configuration.loop);
  emulator.clock = options.clock;
  emulator.lockstep = configuration.lockstep;
  emulator.command_cycle_ms = signal_map.CommandCycleMs();
  emulator.max_counter_jump = configuration.can.command.max_counter_jump;
  emulator.safety = configuration::Resolved(configuration.safety, signal_map.CommandCycleMs());
  emulator.real_time = options.real_time;
  if (options.clock == emulator::Clock::kLockstep && configuration.can.emulate_bit_rate_bit_s != 0)
    emulator.lockstep_bus = BusModelOf(configuration.can);
  return emulator;
}

/// Null where faults over CAN are not allowed.
std::unique_ptr<emulator::FaultPort> OpenFaultPort(const configuration::Configuration& configuration,
                                                   const signal_map::SignalMap& signal_map,
                                                   const fault_words::Permissions& permissions) {
  if (!configuration.fault.allow_can) return nullptr;
  return std::make_unique<emulator::FaultPort>(
      signal_map.Databases(),
      emulator::FaultPort::Rights{permissions.faults.surroundings, permissions.armed,
                                  signal_map.MessageCount(), simulation::Quantities().size()});
}

}  // namespace

int RunOnBus(const RunOptions& options, const RunSetup& setup, const std::optional<emulator::Snapshot>& from,
             const StopSignals& signals) {
  const configuration::Configuration& configuration = setup.configuration;
  emulator::EmulatorOptions emulator_options = EmulatorOptionsOf(options, configuration, setup.signal_map);
  if (const std::string& mismatch = setup.signal_map.CycleMismatch(); !mismatch.empty())
    spdlog::warn("{}", mismatch);
  CheckBusLoad(setup.signal_map, configuration.can);
  const can::BusOptions bus_options = BusOptionsOf(setup.signal_map, configuration, emulator_options);
  can::Network network(ResolveBuses(WantedBuses(options.buses, configuration), configuration.can),
                       bus_options);
  ReportBuses(network, configuration.can.bit_rate_bit_s);

  const configuration::RunTexts texts = configuration::DescribeConfiguration(configuration);
  const auto recorder = options.recording.Open(
      texts, setup.signal_map, options.clock == emulator::Clock::kReal ? "real time" : "lockstep", from,
      BusNames(network));
  emulator_options.task.recorder = recorder.get();
  const fault_words::FaultContext faults = FaultContextOf(setup, network, bus_options.wanted, options.clock);
  const fault_words::Permissions permissions = PermissionsOf(configuration, faults, network);
  const auto fault_port = OpenFaultPort(configuration, setup.signal_map, permissions);
  emulator_options.fault_port = fault_port.get();
  std::optional<ScenarioOnBus> scenario;
  if (setup.scenario) {
    scenario.emplace(*setup.scenario, permissions, options.clock);
    scenario->AddTo(emulator_options.task);
  }
  emulator::Emulator emulator(setup.configuration.model, setup.start, setup.signal_map, network,
                              emulator_options);
  if (from) emulator.Restore(*from);
  const std::string ready = ReadyLine(network, emulator.Final(), emulator_options);
  SnapshotWriter snapshots(options.snapshots, texts);
  const auto control = OpenControl(options.control, emulator, permissions);
  Reloader reloader(texts, [&] { return options.configuration.Load(); },
                    {{"fault.armed", [&](const configuration::Configuration& now) {
                        const fault_words::Permissions permitted = PermissionsOf(now, faults, network);
                        if (control) control->Permit(permitted);
                        if (fault_port) fault_port->Arm(permitted.armed);
                      }}});
  BusWatch buses(emulator, network, configuration.can);
  Watch watch(emulator, network, emulator_options, options.statistics, snapshots, control.get(), reloader,
              buses);
  std::string missing;
  for (const std::string& one : emulator.Start()) missing += (missing.empty() ? "" : "; ") + one;
  if (!missing.empty()) spdlog::warn("not fully real-time: {}", missing);
  for (const auto& bus : network.Buses()) {
    if (const std::string hint = bus->ConnectHint(); !hint.empty()) spdlog::info("{}", hint);
  }
  std::cout << ready << std::flush;

  watch.Run(signals);
  emulator.Stop();
  if (const std::uint64_t unread = network.Drain(); unread != 0) {
    spdlog::warn("the last {} frames were not read: the client read nothing for {} s, or went on for {} s",
                 unread, can::kDrainStalled / std::chrono::seconds(1),
                 can::kDrainLongest / std::chrono::seconds(1));
  }
  snapshots.WriteAllOrTell(emulator);
  const std::uint64_t lost =
      options.clock == emulator::Clock::kLockstep ? network.Statistics().receive_overflows : 0;
  const Verdict verdict = JudgeRun(emulator.Final(), lost, emulator.ModelledBus());
  std::cout << Summary(emulator, network, emulator_options)
            << FinishRecording(recorder.get(), options.recording.directory, emulator.Final(), verdict.Text())
            << "verdict  " << verdict.Text() << std::endl;
  if (!options.statistics.empty())
    WriteStatistics(options.statistics, emulator, emulator.Final(), network, emulator_options, true);
  if (scenario)
    return scenario->Report(options.scenario, emulator, lost, recorder == nullptr || !recorder->Incomplete());
  return verdict.Valid() ? base::kExitOk : base::kExitNotValid;
}

}  // namespace servohil::run
