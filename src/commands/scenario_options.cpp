#include "commands/scenario_options.hpp"

#include <CLI/CLI.hpp>

namespace servohil::commands {

CLI::Option* AddOptions(CLI::App& command, run::ScenarioOptions& options) {
  CLI::Option* option = command.add_option(
      "--scenario", options.file,
      "scenario (TOML): faults and, without a bus, commands on a time line, and what is expected; "
      "config/scenarios has some");
  option->type_name("FILE");
  command.add_option("--report-json", options.json, "the scenario's verdicts as JSON")
      ->type_name("FILE")
      ->needs(option);
  command.add_option("--report-junit", options.junit, "the scenario's verdicts as JUnit XML")
      ->type_name("FILE")
      ->needs(option);
  return option;
}

}  // namespace servohil::commands
