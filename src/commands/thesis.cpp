#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "base/exit_status.hpp"
#include "commands/commands.hpp"
#include "thesis/figures.hpp"
#include "thesis/groups.hpp"
#include "thesis/report.hpp"

namespace servohil::commands {
namespace {

struct ThesisOptions {
  configuration::ConfigurationOptions configuration;
  std::string plots;
  bool json = false;
  bool markdown = false;
};

int Thesis(const ThesisOptions& options) {
  const thesis::MakeCase make = [&](const thesis::Row& row) {
    return thesis::LoadCase(options.configuration, row);
  };
  thesis::Groups groups;
  thesis::AppendSteadyState(make, groups);
  thesis::AppendCoefficients(make, groups);
  thesis::AppendTransferFunctions(make, groups);
  thesis::AppendLinearTables(make, groups);
  thesis::AppendStabilizerTables(make, groups);
  thesis::AppendSimulatedTables(make, groups);

  const std::vector<std::string> base = make({}).parameters;
  const auto print = options.json       ? thesis::PrintJson
                     : options.markdown ? thesis::PrintMarkdown
                                        : thesis::PrintText;
  print(groups, base);
  if (!options.plots.empty()) {
    thesis::WriteFigures(make, options.plots);
    thesis::DrawFigures(options.plots);
  }
  return thesis::Summarise(groups).unexplained == 0 ? base::kExitOk : base::kExitNotValid;
}

}  // namespace

void AddThesisCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<ThesisOptions>();
  CLI::App& command = *program.add_subcommand(
      "thesis", "Recomputes the source's printed numbers, tables and figures, each beside what it prints");
  AddOptions(command, options->configuration);
  command
      .add_option("--plots", options->plots,
                  "also writes Figures 3, 4, 6 to 12, 14 to 31, 33 to 42 into this folder: CSV and PNG each")
      ->type_name("DIR");
  auto* json =
      command.add_flag("--json", options->json, "prints JSON, with the full parameter set of every row");
  command.add_flag("--markdown", options->markdown, "prints Markdown tables")->excludes(json);
  command.footer(
      "Exit status 1: a number deviates by more than half its last printed digit, and not for a known "
      "reason.\n"
      "A known reason names what is right instead (from an independent computation), and ours must meet "
      "that.");
  command.callback([options, &exit_status] { exit_status = Thesis(*options); });
}

}  // namespace servohil::commands
