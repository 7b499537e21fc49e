#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "bench/can.hpp"
#include "bench/cpu.hpp"
#include "bench/kernel.hpp"
#include "bench/limits.hpp"
#include "bench/report.hpp"
#include "commands/commands.hpp"
#include "configuration/rest.hpp"

namespace servohil::commands {
namespace {

struct CheckOptions {
  configuration::ConfigurationOptions configuration;
  double duration_s = 30.0;
  std::string json;
};

bench::Findings Look(const configuration::Configuration& configuration) {
  const bench::SystemFiles files;
  if (bench::IsUserModeLinux(files))
    throw base::EnvironmentError(
        "check: this is a user-mode Linux, whose time says nothing about a bench; run it outside");
  bench::Findings all;
  const auto add = [&](const bench::Findings& some) { all.insert(all.end(), some.begin(), some.end()); };
  add(bench::CheckKernel(files, bench::TimerResolutionNs()));
  add(bench::CheckLimits(files, configuration.loop.priority));
  add(bench::CheckCpu(files, configuration.loop.cpu));
  add(bench::CheckBuses(files, configuration.can, bench::AskKernel));
  return all;
}

/// What the limits promised and the kernel then refused, in a container for instance. Where a finding tells
/// the reason already, with its fix, nothing is added.
void AddRefusals(bench::Findings& findings, const rt::Shortcomings& missing) {
  for (const bench::Finding& finding : findings) {
    const bool is_reason =
        finding.name == "priority" || finding.name == "memory" || finding.name == "isolation";
    if (is_reason && finding.grade == bench::Grade::kBad) return;
  }
  for (const std::string& one : missing) findings.push_back({"real time", bench::Grade::kBad, one, ""});
}

int Check(const CheckOptions& options) {
  const configuration::Configuration configuration = options.configuration.Load();
  const model::SteadyState start =
      configuration::RequireSteadyStateAt(model::Derived(configuration.model), configuration.start_x3_in);
  std::ofstream file;
  if (!options.json.empty() && options.json != "-") {
    file.open(options.json);
    if (!file) throw base::UsageError("--json " + options.json + ": cannot be written");
  }
  bench::Report report{
      .findings = Look(configuration), .measurement = {}, .loop = configuration.loop, .verdict = {}};
  report.measurement = bench::Measure(configuration.model, start, configuration.loop, options.duration_s);
  AddRefusals(report.findings, report.measurement.missing);
  report.verdict = bench::Judge(report.findings, report.measurement, configuration.loop.wake_ticks);

  std::cout << (options.json == "-" ? bench::AsJson(report) : bench::AsText(report)) << std::flush;
  if (file.is_open() && !(file << bench::AsJson(report) << std::flush))
    throw base::EnvironmentError("--json " + options.json + ": the disk did not take it");
  return report.verdict.as_configured ? base::kExitOk : base::kExitNotValid;
}

}  // namespace

void AddCheckCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App& command = *program.add_subcommand(
      "check", "Qualifies this machine as a bench: settings, limits, the loop under load");
  AddOptions(command, options->configuration);
  command.add_option("--duration", options->duration_s, "of the measurement [s]; default: 30")
      ->type_name("S")
      ->check(CLI::Range(0.5, 86'400.0));
  command
      .add_option("--json", options->json, "writes JSON, too; -: instead of the text; keys carry their units")
      ->type_name("FILE|-");
  command.footer(
      "OK; WARN: may cost latency; BAD: `run --rt require` would refuse, or the bus would not carry the "
      "frames.\n"
      "The loop runs 1, 2, 5, 10, 20, 50 and loop.wake_ticks ticks per wake-up until one number holds: "
      "worst\n"
      "lateness and worst compute time together at most half the wake period, beside a thread on each CPU "
      "that\n"
      "loads memory and disk. FIT: nothing is BAD and a number holds.\n"
      "Exit status: 0 fit at loop.wake_ticks or better, 1 not.");
  command.callback([options, &exit_status] { exit_status = Check(*options); });
}

}  // namespace servohil::commands
