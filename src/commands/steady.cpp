#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "commands/commands.hpp"
#include "configuration/rest.hpp"

namespace servohil::commands {
namespace {

struct SteadyOptions {
  configuration::ConfigurationOptions configuration;
  std::optional<double> x3_in;
  std::optional<double> p1_psi;
  bool json = false;
};

void Print(const model::SteadyState& s, bool json) {
  const nlohmann::ordered_json values = {
      {"x1_in", s.outputs.x1_in},
      {"x2_in", s.outputs.x2_in},
      {"x3_in", s.state.x3_in},
      {"x4_in", s.outputs.x4_in},
      {"p1_psi", s.p1_psi},
      {"p3_psi", s.state.p3_psi},
      {"p4_psi", s.state.p4_psi},
      {"q3_in3_s", s.outputs.q3_in3_s},
      {"q4_in3_s", s.outputs.q4_in3_s},
      {"q5_in3_s", s.outputs.q5_in3_s},
      {"q6_in3_s", s.outputs.q6_in3_s},
  };
  if (json) {
    std::cout << values.dump(2) << '\n';
    return;
  }
  for (const auto& [key, value] : values.items())
    std::printf("%-9s %.9g\n", key.c_str(), value.get<double>());
}

}  // namespace

void AddSteadyCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<SteadyOptions>();
  CLI::App& command =
      *program.add_subcommand("steady", "Steady state for a piston position or a control pressure");
  AddOptions(command, options->configuration);
  auto* x3 = command.add_option("--x3", options->x3_in, "piston position [in]")->type_name("IN");
  auto* p1 =
      command.add_option("--p1", options->p1_psi, "control oil pressure [psi gauge]")->type_name("PSI");
  x3->excludes(p1);
  command.add_flag("--json", options->json, "prints JSON; keys carry their units");
  command.callback([options, &exit_status] {
    if (!options->x3_in && !options->p1_psi)
      throw base::UsageError("steady: --x3 IN or --p1 PSI is required");
    const model::Derived derived(options->configuration.Load().model);
    Print(options->x3_in ? configuration::RequireSteadyStateAt(derived, *options->x3_in)
                         : configuration::RequireSteadyStateForP1(derived, *options->p1_psi),
          options->json);
    exit_status = base::kExitOk;
  });
}

}  // namespace servohil::commands
