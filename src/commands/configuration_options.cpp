#include <CLI/CLI.hpp>
#include <iostream>

#include "commands/commands.hpp"

namespace servohil::commands {

void AddOptions(CLI::App& command, configuration::ConfigurationOptions& options) {
  command
      .add_option(
          "-c,--config", options.file,
          "configuration (TOML); default: ./config/servohil.toml, else the one installed with the program")
      ->type_name("FILE");
  command
      .add_option("--set", options.settings,
                  "overrides one key of the configuration, e.g. servo.underlap_in=0.001; repeatable")
      ->type_name("KEY=VALUE")
      ->take_all();
  command.add_flag_callback(
      "--help-keys",
      [] {
        std::cout << "Configuration keys: name = default unit [range], meaning\n"
                  << configuration::DescribeKeys();
        throw CLI::Success();
      },
      "lists every configuration key with unit, default and range");
}

}  // namespace servohil::commands
