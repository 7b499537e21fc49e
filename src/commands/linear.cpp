#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "commands/commands.hpp"
#include "linear/analysis.hpp"

namespace servohil::commands {
namespace {

struct CommandOptions {
  configuration::ConfigurationOptions configuration;
  linear::LinearOptions linear;
  std::vector<std::string> map;
  std::string output;
  bool json = false;
};

void AnalyseOrMap(CommandOptions options) {
  if (!options.linear.x3_in && !options.linear.p1_psi)
    throw base::UsageError("linear: --x3 IN or --p1 PSI is required");
  if (options.map.empty() != options.output.empty())
    throw base::UsageError("linear: --map and -o go together: --map KEY=LOW:HIGH KEY=LOW:HIGH -o map.csv");
  if (options.linear.model == linear::LinearModel::kThesis)
    options.configuration.settings.emplace_back("model.physics=thesis");
  if (!options.map.empty()) {
    linear::WriteMap(options.configuration.file, options.configuration.settings, options.map, options.linear,
                     options.output);
    return;
  }
  const linear::LinearAnalysis analysis = linear::Analyse(options.configuration.Load().model, options.linear);
  options.json ? linear::PrintJson(analysis) : linear::PrintText(analysis);
}

}  // namespace

void AddLinearCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<CommandOptions>();
  linear::LinearOptions& linear = options->linear;
  CLI::App& command = *program.add_subcommand(
      "linear", "Linear model at an operating point: poles, transfer function, margins, stability map");
  AddOptions(command, options->configuration);
  auto* x3 = command.add_option("--x3", linear.x3_in, "piston position [in]")->type_name("IN");
  command.add_option("--p1", linear.p1_psi, "control oil pressure [psi gauge]")
      ->type_name("PSI")
      ->excludes(x3);
  command
      .add_option("--model", linear.model,
                  "nonlinear (default): the simulated model, linearised; thesis: its Appendix B (G with the "
                  "stabilizer)")
      ->type_name("nonlinear|thesis")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, linear::LinearModel>{{"nonlinear", linear::LinearModel::kNonlinear},
                                                     {"thesis", linear::LinearModel::kThesis}},
          CLI::ignore_case));
  command
      .add_option(
          "--a4", linear.thesis.full_a4,
          "thesis model: the capillary's a4 as Appendix B prints it (printed: 0.2901, default) or with "
          "the factor of (3.16) (full: 11.87)")
      ->type_name("printed|full")
      ->transform(CLI::CheckedTransformer(std::map<std::string, bool>{{"printed", false}, {"full", true}}));
  command
      .add_option("--v3", linear.thesis.v3_in3, "thesis model: volume under the piston [in3]; default: 344")
      ->type_name("IN3")
      ->check(CLI::Range(0.1, 1e5));
  command
      .add_option("--k3", linear.thesis.k3_lbf_in,
                  "thesis model: slope of the load force [lbf/in]; default: -3450")
      ->type_name("LBF/IN");
  command
      .add_option(
          "--map", options->map,
          "stability over two keys of the configuration, on a grid of N (default 41) values each, to -o; "
          "tools/plot_map.py draws it")
      ->type_name("KEY=LOW:HIGH[:N]")
      ->expected(2);
  command.add_option("-o,--output", options->output, "CSV file of --map; -: standard output")
      ->type_name("FILE");
  command.add_flag("--json", options->json, "prints JSON; keys carry their units");
  command.footer(
      "Dry friction has no linear model: with friction.coulomb_psi or breakaway_psi (Stribeck) the analysis "
      "is\n"
      "that of the sliding, frictionless piston. Margins: the loop is broken where the cam sets the bushing "
      "(x4).");
  command.callback([options, &exit_status] {
    AnalyseOrMap(*options);
    exit_status = base::kExitOk;
  });
}

}  // namespace servohil::commands
