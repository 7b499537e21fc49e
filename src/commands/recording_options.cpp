#include "commands/recording_options.hpp"

#include <CLI/CLI.hpp>

namespace servohil::commands {

void AddOptions(CLI::App& command, run::RecordingOptions& options) {
  command
      .add_option(
          "--record", options.directory,
          "records into this directory: servohil.h5 (HDF5: states, commands, what the frames said) and "
          "bus.log (candump); `servohil replay` runs it again")
      ->type_name("DIR");
  command
      .add_option("--record-every", options.every_ticks,
                  "records every n-th tick; default: 1. Commands and frames all")
      ->type_name("TICKS")
      ->check(CLI::Range(1, 1'000'000))
      ->needs("--record");
}

}  // namespace servohil::commands
