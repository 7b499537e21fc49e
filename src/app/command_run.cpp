#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "bus_setup.hpp"
#include "bus_watch.hpp"
#include "check_configuration.hpp"
#include "commands.hpp"
#include "control/server.hpp"
#include "formatted.hpp"
#include "log.hpp"
#include "p1_script.hpp"
#include "recording_options.hpp"
#include "reload.hpp"
#include "run_report.hpp"
#include "run_statistics.hpp"
#include "scenario/evaluator.hpp"
#include "scenario_options.hpp"
#include "scripted_run.hpp"
#include "servohil/app/contract.hpp"
#include "servohil/app/emulator.hpp"
#include "servohil/app/envelope_check.hpp"
#include "servohil/app/run_texts.hpp"
#include "servohil/app/ticks.hpp"
#include "servohil/can/network.hpp"
#include "servohil/error.hpp"
#include "snapshot_writer.hpp"
#include "stop_signals.hpp"
#include "watch.hpp"

namespace servohil::app {
namespace {

struct Options {
  ConfigurationOptions configuration;
  std::vector<std::string> buses;
  Clock clock = Clock::kReal;
  RealTime real_time = RealTime::kPrefer;
  double duration_s = 0.0;
  std::filesystem::path script;
  RecordingOptions recording;
  std::filesystem::path statistics;
  std::string control;
  std::filesystem::path from;
  std::filesystem::path snapshots = ".";
  std::vector<double> snapshot_at_s;
  bool check_configuration = false;
  ScenarioOptions scenario;
};

/// What is to be run: all of it from the configuration, or from a snapshot.
struct Setup {
  explicit Setup(const Options& options)
      : scenario(options.scenario.Open()),
        configuration(LoadFor(scenario.get(), options.configuration)),
        derived(configuration.model),
        start(RequireSteadyStateAt(derived, configuration.start_x3_in)),
        contract(configuration) {}

  std::unique_ptr<scenario::ScenarioFile> scenario;  ///< null: none
  Configuration configuration;
  model::Derived derived;
  model::SteadyState start;
  Contract contract;
};

/// A scenario on a bus: faults at their ticks, expectations held against every tick; the governor commands.
class ScenarioOnBus {
 public:
  ScenarioOnBus(const scenario::ScenarioFile& file, const control::Permissions& permissions, Clock clock)
      : scenario_(file.Understand(permissions)), evaluator_(scenario_, clock != Clock::kReal) {
    if (!scenario_.commands.empty())
      spdlog::info("{}: the governor on the bus commands, not the scenario", scenario_.file.string());
  }

  void AddTo(TaskOptions& task) {
    task.is_scenario = true;
    task.duration_ticks = scenario_.duration_ticks;
    task.wait_ticks = scenario_.wait_ticks;
    task.script = scenario_.faults;
    task.feed = &evaluator_.Feed();
  }

  /// After the run. @return exit status
  int Report(const ScenarioOptions& options, const Emulator& emulator, std::uint64_t lost_frames,
             bool recording_complete) {
    // That the model left its domain is for the expectations to tell.
    Telemetry end = emulator.Final();
    end.sample.model_fault = false;
    std::vector<std::string> reasons = JudgeRun(end, lost_frames, emulator.ModelledBus()).reasons;
    if (!recording_complete) reasons.emplace_back("the recording is incomplete");
    if (emulator.ScriptRefused() > 0) reasons.emplace_back("faults were refused: too many at once");
    return options.Report(scenario_, evaluator_.Judge(std::move(reasons)));
  }

 private:
  const scenario::Scenario scenario_;
  scenario::Evaluator evaluator_;
};

TaskOptions TaskOptionsOf(const Options& options, const LoopSettings& loop) {
  TaskOptions task;
  task.loop = loop;
  task.duration_ticks = TicksOf(options.duration_s);
  for (const double s : options.snapshot_at_s) task.snapshot_ticks.push_back(TicksOf(s));
  std::sort(task.snapshot_ticks.begin(), task.snapshot_ticks.end());
  return task;
}

std::string ReadyLine(const can::Network& network, const Telemetry& start, const EmulatorOptions& options) {
  std::string text = "ready: ";
  for (const auto& bus : network.Buses()) text += (bus == network.Buses().front() ? "" : ", ") + bus->Name();
  text += Formatted("; %s x3 %.4f in, P1 %.4f psi", start.status.commanded ? "goes on at" : "at rest at",
                    start.sample.state.x3_in, start.sample.p1_psi);
  if (!start.status.commanded) text += ", until the first command";
  if (options.clock == Clock::kReal)
    return text + Formatted("; wake-up every %.1f ms\n", options.task.loop.wake_ticks / 10.0);
  return text + Formatted("; lockstep: %.1f ms per ", options.lockstep.ticks / 10.0) +
         (options.lockstep.sync_id < 0 ? "command" : Formatted("frame 0x%X", options.lockstep.sync_id)) +
         "\n";
}

can::BusModelSettings BusModelOf(const CanSettings& can) {
  return {static_cast<std::uint32_t>(can.emulate_bit_rate_bit_s), static_cast<std::size_t>(can.queue_length)};
}

/// Faults over CAN: their identifier is let in before the buses are known, their rights come after.
struct FaultMessages {
  explicit FaultMessages(const Configuration& configuration)
      : databases(can::ReadDbcs(configuration.can.dbc)),
        request(*databases.RequireMessage("FAULT_Request").message),
        response(*databases.RequireMessage("FAULT_Response").message) {}

  const can::Databases databases;
  const can::Message& request;
  const can::Message& response;
};

can::BusOptions BusOptionsOf(const Setup& setup, const EmulatorOptions& options,
                             const std::optional<FaultMessages>& faults) {
  can::BusOptions bus;
  bus.wanted = setup.contract.Wanted();
  if (faults) bus.wanted.push_back({faults->request.id, faults->request.extended});
  if (options.clock == Clock::kLockstep && options.lockstep.sync_id >= 0)
    bus.wanted.push_back({static_cast<std::uint32_t>(options.lockstep.sync_id), false});
  // What another node sends with an identifier of ours is to be seen, too.
  for (std::size_t i = 0; i < setup.contract.MessageCount(); ++i)
    bus.wanted.push_back({setup.contract.MessageOf(i).id, setup.contract.MessageOf(i).extended});
  const CanSettings& can = setup.configuration.can;
  bus.bit_rate_bit_s = static_cast<std::uint32_t>(can.bit_rate_bit_s);
  bus.allow_physical = can.allow_physical;
  if (can.configure) bus.configure = LinkSettingsOf(can);
  if (can.emulate_bit_rate_bit_s == 0) return bus;
  bus.wanted.clear();  // everybody's frames take their time
  if (options.clock == Clock::kReal) bus.model = BusModelOf(can);
  return bus;
}

/// For bus.log: "vcan0", "pts/3".
std::vector<std::string> BusNames(const can::Network& network) {
  std::vector<std::string> names;
  for (const auto& bus : network.Buses()) {
    const std::string name = bus->Name().substr(bus->Name().find(':') + 1);
    names.push_back(name.rfind("/dev/", 0) == 0 ? name.substr(5) : name);
  }
  return names;
}

FaultContext FaultContextOf(const Setup& setup, const can::Network& network,
                            const std::vector<can::WantedId>& wanted, Clock clock) {
  FaultContext context;
  context.contract = &setup.contract;
  context.surroundings.unfaulted = &setup.configuration.model;
  context.surroundings.real_time = clock == Clock::kReal;
  context.surroundings.counter = setup.contract.AnyPublished([](const can::E2eLayout&) { return true; });
  context.surroundings.checksum = setup.contract.AnyPublished(can::HasChecksum);
  for (const auto& bus : network.Buses()) {
    const char* why = bus->WhyNoErrorFrames();
    if (why != nullptr) context.surroundings.why_no_error_frames = why;
    if (!bus->Interface().empty()) context.received = wanted;
  }
  return context;
}

/// Faults belong on a bus that no real machine is on, unless the configuration says otherwise.
control::Permissions PermissionsOf(const Configuration& configuration, const FaultContext& context,
                                   const can::Network& network) {
  control::Permissions permissions{context, configuration.fault.armed == Armed::kYes, {}};
  if (permissions.armed) return permissions;
  if (configuration.fault.armed == Armed::kNo) {
    permissions.why_not_armed = "faults are not armed: fault.armed = \"no\"";
    return permissions;
  }
  for (const auto& bus : network.Buses()) {
    if (bus->IsVirtual()) continue;
    permissions.why_not_armed = "faults are not armed: " + bus->Name() +
                                " may be physical; --set fault.armed=yes if it may be disturbed";
    return permissions;
  }
  permissions.armed = true;
  return permissions;
}

/// @param path  empty: where nobody has to be told; taken by another run, this one goes without
std::unique_ptr<control::Server> OpenControl(const std::string& path, Emulator& emulator,
                                             control::Permissions permissions) {
  if (path == "none") return nullptr;
  try {
    auto server = std::make_unique<control::Server>(
        path.empty() ? control::DefaultSocket() : std::filesystem::path(path), emulator,
        std::move(permissions));
    spdlog::info("control socket: {}", server->Path().string());
    return server;
  } catch (const EnvironmentError& error) {
    if (!path.empty()) throw;
    spdlog::info("no control socket: {}", error.what());
    return nullptr;
  }
}

int RunOnBus(const Options& options, const Setup& setup, const std::optional<Snapshot>& from,
             const StopSignals& signals) {
  const Configuration& configuration = setup.configuration;
  EmulatorOptions emulator_options;
  emulator_options.task = TaskOptionsOf(options, configuration.loop);
  emulator_options.clock = options.clock;
  emulator_options.lockstep = configuration.lockstep;
  emulator_options.command_cycle_ms = configuration.can.command.cycle_ms;
  emulator_options.max_counter_jump = configuration.can.command.max_counter_jump;
  emulator_options.safety = Resolved(configuration.safety, configuration.can.command.cycle_ms);
  emulator_options.real_time = options.real_time;
  if (options.clock == Clock::kLockstep && configuration.can.emulate_bit_rate_bit_s != 0)
    emulator_options.lockstep_bus = BusModelOf(configuration.can);

  std::optional<FaultMessages> fault_messages;
  if (configuration.fault.allow_can) fault_messages.emplace(configuration);
  CheckBusLoad(setup.contract, configuration.can);
  const can::BusOptions bus_options = BusOptionsOf(setup, emulator_options, fault_messages);
  can::Network network(
      ResolveBuses(options.buses.empty() ? configuration.can.buses : options.buses, configuration.can),
      bus_options);
  ReportBuses(network, configuration.can.bit_rate_bit_s);

  const RunTexts texts = DescribeConfiguration(configuration);
  const auto recorder =
      options.recording.Open(texts, setup.contract, options.clock == Clock::kReal ? "real time" : "lockstep",
                             from, BusNames(network));
  emulator_options.task.recorder = recorder.get();
  const FaultContext faults = FaultContextOf(setup, network, bus_options.wanted, options.clock);
  const control::Permissions permissions = PermissionsOf(configuration, faults, network);
  std::optional<FaultPort> fault_port;
  if (fault_messages) {
    fault_port.emplace(fault_messages->request, fault_messages->response,
                       FaultPort::Rights{permissions.faults.surroundings, permissions.armed,
                                         setup.contract.MessageCount(), Quantities().size()});
    emulator_options.fault_port = &*fault_port;
  }
  std::optional<ScenarioOnBus> scenario;
  if (setup.scenario) {
    scenario.emplace(*setup.scenario, permissions, options.clock);
    scenario->AddTo(emulator_options.task);
  }
  Emulator emulator(setup.configuration.model, setup.start, setup.contract, network, emulator_options);
  if (from) emulator.Restore(*from);
  const std::string ready = ReadyLine(network, emulator.Final(), emulator_options);
  SnapshotWriter snapshots(options.snapshots, texts);
  const auto control = OpenControl(options.control, emulator, permissions);
  Reloader reloader(texts, [&] { return options.configuration.Load(); },
                    {{"fault.armed", [&](const Configuration& now) {
                        if (control) control->Permit(PermissionsOf(now, faults, network));
                      }}});
  BusWatch buses(emulator, network, configuration.can);
  Watch watch(emulator, network, emulator_options, options.statistics, snapshots, control.get(), reloader,
              buses, setup.contract);
  std::string missing;
  for (const std::string& one : emulator.Start()) missing += (missing.empty() ? "" : "; ") + one;
  if (!missing.empty()) spdlog::warn("not fully real-time: {}", missing);
  for (const auto& bus : network.Buses()) {
    if (const std::string hint = bus->ConnectHint(); !hint.empty()) spdlog::info("{}", hint);
  }
  std::cout << ready << std::flush;

  watch.Run(signals);
  emulator.Stop();
  snapshots.WriteAllOrTell(emulator);
  const std::uint64_t lost = options.clock == Clock::kLockstep ? network.Statistics().receive_overflows : 0;
  const Verdict verdict = JudgeRun(emulator.Final(), lost, emulator.ModelledBus());
  std::cout << Summary(emulator, network, emulator_options)
            << FinishRecording(recorder.get(), options.recording.directory, emulator.Final(), verdict.Text())
            << "verdict  " << verdict.Text() << std::endl;
  if (!options.statistics.empty())
    WriteStatistics(options.statistics, emulator, emulator.Final(), network, emulator_options, true);
  if (scenario)
    return scenario->Report(options.scenario, emulator, lost, recorder == nullptr || !recorder->Incomplete());
  return verdict.Valid() ? kExitOk : kExitNotValid;
}

/// --clock fast: no bus, commands from the script.
int RunFast(const Options& options, const Setup& setup, const std::optional<Snapshot>& from,
            const StopSignals& signals) {
  if (options.script.empty() || options.duration_s == 0.0)
    throw UsageError("run: --clock fast needs --script FILE and --duration S");
  TaskOptions task_options = TaskOptionsOf(options, setup.configuration.loop);
  task_options.safety = LawOf(setup.configuration.safety);
  task_options.supervised = false;
  const std::vector<Influence> script = ReadP1Script(options.script);
  const RunTexts texts = DescribeConfiguration(setup.configuration);
  const auto recorder = options.recording.Open(texts, setup.contract, "fast", from, {});
  task_options.recorder = recorder.get();
  const auto task = std::make_unique<SimulationTask>(setup.configuration.model, setup.start, task_options);
  if (from) task->Restore(*from);
  SnapshotWriter snapshots(options.snapshots, texts);
  RunScript(*task, script, [&] {
    snapshots.WriteAll(*task);
    return task->Now().sample.tick % 10'000 != 0 || signals.Next() == 0;
  });
  const Verdict verdict = JudgeRun(task->Now(), 0);
  std::cout << SimulationSummary(task->Now())
            << FinishRecording(recorder.get(), options.recording.directory, task->Now(), verdict.Text())
            << "verdict  " << verdict.Text() << std::endl;
  return verdict.Valid() ? kExitOk : kExitNotValid;
}

int Run(const Options& options) {
  if (!options.scenario.file.empty() && options.clock == Clock::kFast)
    throw UsageError("run: --clock fast has no bus; `servohil simulate --scenario FILE` is that");
  if (!options.script.empty() && options.clock != Clock::kFast)
    throw UsageError("run: --script is for --clock fast; on a bus the governor gives the commands");
  const StopSignals signals;
  SetUpLog();
  std::optional<Snapshot> from;
  Options effective = options;
  std::optional<TemporaryConfiguration> configuration;
  if (!options.from.empty()) {
    SnapshotFile file = ReadSnapshot(options.from);
    from = file.snapshot;
    configuration.emplace(file.texts);
    effective.configuration.file = configuration->File();
  }
  if (options.check_configuration) return CheckConfiguration(effective.configuration, effective.buses);
  const Setup setup(effective);
  if (const std::string warning = CheckEnvelope(setup.configuration, setup.derived); !warning.empty())
    spdlog::warn("{}", warning);
  return options.clock == Clock::kFast ? RunFast(options, setup, from, signals)
                                       : RunOnBus(options, setup, from, signals);
}

void AddOptions(CLI::App& command, Options& options) {
  options.configuration.AddTo(command);
  command.add_flag("--check-config", options.check_configuration,
                   "checks configuration, DBC and load table, tells every mistake, and runs nothing");
  command
      .add_option(
          "--can", options.buses,
          "bus: socketcan:IFACE, slcan:pty[:LINK], slcan:/dev/TTY, or auto; repeatable; default: can.buses "
          "(auto: vcan0 or can0 if the kernel has it, else slcan:pty)")
      ->type_name("URL")
      ->take_all();
  command
      .add_option("--clock", options.clock,
                  "who lets time pass: real (default), lockstep (each command frame: lockstep.ticks, or each "
                  "frame of lockstep.sync_id), fast (nobody: --script, no bus)")
      ->type_name("real|lockstep|fast")
      ->transform(CLI::CheckedTransformer(
                      std::map<std::string, Clock>{
                          {"real", Clock::kReal}, {"lockstep", Clock::kLockstep}, {"fast", Clock::kFast}},
                      CLI::ignore_case)
                      .description(""));
  command
      .add_option("--rt", options.real_time,
                  "real-time scheduling and locked memory: require (refuse to run without), prefer (default: "
                  "warn), off")
      ->type_name("require|prefer|off")
      ->transform(CLI::CheckedTransformer(std::map<std::string, RealTime>{{"require", RealTime::kRequire},
                                                                          {"prefer", RealTime::kPrefer},
                                                                          {"off", RealTime::kOff}},
                                          CLI::ignore_case)
                      .description(""));
  CLI::Option* scenario = options.scenario.AddTo(command);
  command
      .add_option("--duration", options.duration_s, "ends after this time [s]; default: at SIGINT or SIGTERM")
      ->type_name("S")
      ->excludes(scenario)
      ->check(CLI::Range(model::kTickS, 1e9));
  command
      .add_option(
          "--script", options.script,
          "--clock fast: the commands, CSV t_s,p1_psi; each arrives before the first tick at or after "
          "its time")
      ->type_name("CSV");
  options.recording.AddTo(command);
  command.add_option("--stats", options.statistics, "statistics as JSON, anew each second and at the end")
      ->type_name("FILE");
  command
      .add_option("--control", options.control,
                  "control socket, for `servohil fault` and `servohil status`; none: no such; default: "
                  "/run/servohil/servohil.sock, or in $XDG_RUNTIME_DIR, or /tmp/servohil-UID.sock")
      ->type_name("PATH|none");
  command
      .add_option("--from", options.from,
                  "goes on from a snapshot, with its configuration and DBC; --set changes single keys of it")
      ->type_name("SNAPSHOT")
      ->excludes("--config")
      ->excludes(scenario);
  command
      .add_option("--snapshot-at", options.snapshot_at_s,
                  "writes a snapshot at this simulated time [s]; repeatable; SIGUSR1 writes one at any time")
      ->type_name("S")
      ->check(CLI::Range(model::kTickS, 1e9))
      ->take_all();
  command.add_option("--snapshot-dir", options.snapshots, "where snapshots go; default: here")
      ->type_name("DIR")
      ->check(CLI::ExistingDirectory);
}

}  // namespace

void AddRunCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *program.add_subcommand(
      "run", "Runs the emulator on a CAN bus: in real time, or in lockstep with the governor");
  AddOptions(command, *options);
  command.callback([options, &exit_status] { exit_status = Run(*options); });
}

}  // namespace servohil::app
