/// The program's entry: command line, and the one place where errors become exit statuses.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "base/nearest_name.hpp"
#include "commands/commands.hpp"
#include "run/log.hpp"

namespace servohil::commands {

namespace {

int NoSuchSubcommand(const CLI::App& program, const std::string& word) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands({})) names.push_back(command->get_name());
  std::cerr << "servohil: there is no subcommand " << word << "; "
            << base::DidYouMean(word, names, "--help lists them") << '\n';
  return base::kExitUsage;
}

int Main(int argc, char** argv) {
  CLI::App program(
      "servohil: real-time emulator of a steam turbine's governing-valve servomotor on CAN.\n"
      "Units: in, lbf, s, psi gauge. Time step 0.1 ms.");
  program.set_version_flag("--version", "servohil " SERVOHIL_VERSION);
  program.require_subcommand(1);
  program.footer(
      "Exit status: 0 ok; 1 the run was not valid (late ticks or model fault), or the\n"
      "replay differs; 2 usage or configuration;\n"
      "3 the machine lacks something (interface, permission, disk). Of a scenario: 0 PASS, 1 FAIL, 4 "
      "INVALID.");
  int exit_status = base::kExitOk;
  AddRunCommand(program, exit_status);
  AddFaultCommand(program, exit_status);
  AddStatusCommand(program, exit_status);
  AddReplayCommand(program, exit_status);
  AddSimulateCommand(program, exit_status);
  AddDbcCommand(program, exit_status);
  AddSteadyCommand(program, exit_status);
#ifdef SERVOHIL_ANALYSIS
  AddLinearCommand(program, exit_status);
  AddThesisCommand(program, exit_status);
#endif
  AddCheckCommand(program, exit_status);
  try {
    program.parse(argc, argv);
    return exit_status;
  } catch (const CLI::Success& success) {  // --help, --version
    return program.exit(success);
  } catch (const CLI::ParseError& error) {
    if (program.get_subcommands().empty() && argc > 1 && argv[1][0] != '-')
      return NoSuchSubcommand(program, argv[1]);
    std::cerr << "servohil: " << error.what() << "; --help tells more\n";
    return base::kExitUsage;
  } catch (const base::UsageError& error) {
    run::TellEachLine(error.what());
    return base::kExitUsage;
  } catch (const base::EnvironmentError& error) {
    run::TellEachLine(error.what());
    return base::kExitEnvironment;
  }
}

}  // namespace
}  // namespace servohil::commands

int main(int argc, char** argv) {
  try {
    return servohil::commands::Main(argc, argv);
  } catch (const std::exception& error) {  // out of memory, a file system that vanished
    std::fprintf(stderr, "servohil: %s\n", error.what());
    return servohil::base::kExitEnvironment;
  }
}
