#include "commands/run_options.hpp"

#include <CLI/CLI.hpp>

#include <map>

#include "commands/commands.hpp"
#include "commands/recording_options.hpp"
#include "commands/scenario_options.hpp"

namespace servohil::commands {

void AddOptions(CLI::App& command, run::RunOptions& options) {
  AddOptions(command, options.configuration);
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
                      std::map<std::string, emulator::Clock>{{"real", emulator::Clock::kReal},
                                                             {"lockstep", emulator::Clock::kLockstep},
                                                             {"fast", emulator::Clock::kFast}},
                      CLI::ignore_case)
                      .description(""));
  command
      .add_option("--rt", options.real_time,
                  "real-time scheduling and locked memory: require (refuse to run without), prefer (default: "
                  "warn), off")
      ->type_name("require|prefer|off")
      ->transform(CLI::CheckedTransformer(
                      std::map<std::string, emulator::RealTime>{{"require", emulator::RealTime::kRequire},
                                                                {"prefer", emulator::RealTime::kPrefer},
                                                                {"off", emulator::RealTime::kOff}},
                      CLI::ignore_case)
                      .description(""));
  CLI::Option* with_scenario = AddOptions(command, options.scenario);
  command
      .add_option("--duration", options.duration_s, "ends after this time [s]; default: at SIGINT or SIGTERM")
      ->type_name("S")
      ->excludes(with_scenario)
      ->check(CLI::Range(model::kTickS, 1e9));
  command
      .add_option(
          "--script", options.script,
          "--clock fast: the commands, CSV t_s,p1_psi; each arrives before the first tick at or after "
          "its time")
      ->type_name("CSV");
  AddOptions(command, options.recording);
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
      ->excludes(with_scenario);
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

}  // namespace servohil::commands
