#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "base/formatted.hpp"
#include "commands/commands.hpp"
#include "commands/recording_options.hpp"
#include "commands/scenario_options.hpp"
#include "configuration/envelope_check.hpp"
#include "configuration/rest.hpp"
#include "emulator/simulation_task.hpp"
#include "model/ticks.hpp"
#include "run/p1_script.hpp"
#include "run/report.hpp"
#include "run/scripted_run.hpp"
#include "scenario/simulated_run.hpp"

namespace servohil::commands {
namespace {

struct SimulateOptions {
  configuration::ConfigurationOptions configuration;
  std::optional<double> x3_in;
  double duration_s = 0.0;
  std::optional<double> p1_step_psi;
  std::filesystem::path p1_file;
  int every_ticks = 1;
  std::optional<std::string> output;
  run::RecordingOptions recording;
  run::ScenarioOptions scenario;
};

/// P1 over time: the steady state's, then each value from its tick on.
std::vector<recording::Stimulus> P1Over(double rest_psi, const SimulateOptions& options) {
  std::vector<recording::Stimulus> changes = {
      run::CommandAfter(0, rest_psi + options.p1_step_psi.value_or(0.0))};
  if (options.p1_file.empty()) return changes;
  const std::vector<recording::Stimulus> script = run::ReadP1Script(options.p1_file);
  changes.insert(changes.end(), script.begin(), script.end());
  return changes;
}

/// CSV with every bit of every number. Throws when the disk does not take it.
class CsvOutput {
 public:
  explicit CsvOutput(const std::string& path)
      : path_(path), file_(path == "-" ? stdout : std::fopen(path.c_str(), "w")) {
    if (file_ == nullptr) throw base::EnvironmentError(path + ": cannot be written");
    std::fputs(
        "t_s,p1_psi,x3_in,v3_in_s,p3_psi,p4_psi,p8_psi,x1_in,x2_in,x4_in,q3_in3_s,q4_in3_s,q5_in3_s,q6_in3_s,"
        "friction_psi,stuck\n",
        file_);
  }
  ~CsvOutput() {
    if (file_ != nullptr && file_ != stdout) std::fclose(file_);
  }
  CsvOutput(const CsvOutput&) = delete;
  CsvOutput& operator=(const CsvOutput&) = delete;

  void Write(const simulation::Sample& s, const model::Outputs& o) {
    const double values[] = {model::SecondsOf(s.tick),
                             s.p1_psi,
                             s.state.x3_in,
                             s.state.v3_in_s,
                             s.state.p3_psi,
                             s.state.p4_psi,
                             s.state.p8_psi,
                             o.x1_in,
                             o.x2_in,
                             o.x4_in,
                             o.q3_in3_s,
                             o.q4_in3_s,
                             o.q5_in3_s,
                             o.q6_in3_s,
                             o.friction_psi};
    for (const double value : values) std::fprintf(file_, "%.17g,", value);
    std::fputs(s.state.mode.PistonRests() ? "1\n" : "0\n", file_);
  }

  void Finish() {
    const bool failed = std::ferror(file_) != 0 || std::fflush(file_) != 0;
    if (failed)
      throw base::EnvironmentError((path_ == "-" ? "standard output" : path_) +
                                   ": writing failed (disk full?)");
  }

 private:
  std::string path_;
  std::FILE* file_;
};

/// What is wrong with it, on standard error. @return exit status
int Report(const simulation::Sample& end) {
  if (end.model_fault) {
    std::cerr << base::Formatted(
        "servohil: model fault at t = %.4f s: the state left the model's domain after x3 = %.6g in, "
        "P3 = %.6g psi; the output ends there\n",
        model::SecondsOf(end.tick), end.state.x3_in, end.state.p3_psi);
    return base::kExitNotValid;
  }
  if (end.unresolved_ticks > 0) {
    std::cerr << base::Formatted(
        "servohil: %llu of %llu ticks were faster than %d sub-steps resolve: less accurate there\n",
        static_cast<unsigned long long>(end.unresolved_ticks), static_cast<unsigned long long>(end.tick),
        model::kMaxSubSteps);
  }
  return base::kExitOk;
}

/// Nothing where there is no --record.
std::unique_ptr<recording::Recorder> OpenRecording(const SimulateOptions& options,
                                                   const configuration::Configuration& configuration) {
  if (options.recording.directory.empty()) return nullptr;
  const signal_map::SignalMap signal_map(configuration);
  return options.recording.Open(configuration::DescribeConfiguration(configuration), signal_map, "fast",
                                std::nullopt, {});
}

/// Without a scenario: commands from the options. With one: commands, faults and what is expected.
int Simulate(const SimulateOptions& options) {
  const auto file = options.scenario.Open();
  configuration::Configuration configuration = run::LoadFor(file.get(), options.configuration);
  configuration.start_x3_in = options.x3_in.value_or(configuration.start_x3_in);
  const model::Derived derived(configuration.model);
  if (const std::string warning = configuration::CheckEnvelope(configuration, derived); !warning.empty())
    std::cerr << "servohil: " << warning << '\n';
  const model::SteadyState start = configuration::RequireSteadyStateAt(derived, configuration.start_x3_in);
  std::optional<scenario::SimulatedRun> scenario;
  if (file) scenario.emplace(*file, configuration, start);
  const std::vector<recording::Stimulus> script =
      file ? std::vector<recording::Stimulus>{} : P1Over(start.p1_psi, options);
  const auto recorder = OpenRecording(options, configuration);
  emulator::TaskOptions task_options;
  task_options.duration_ticks = model::TicksOf(options.duration_s);
  task_options.supervised = false;
  if (scenario) scenario->AddTo(task_options);
  task_options.recorder = recorder.get();
  const auto task = std::make_unique<emulator::SimulationTask>(configuration.model, start, task_options);

  const std::string csv = options.output.value_or(recorder || file ? "" : "-");
  std::optional<CsvOutput> output;
  if (!csv.empty()) output.emplace(csv);
  const auto every = static_cast<std::uint64_t>(options.every_ticks);
  const auto write = [&] {
    const simulation::Sample& sample = task->Now().sample;
    if (output && sample.tick % every == 0) output->Write(sample, task->Now().outputs);
  };
  write();
  if (scenario) scenario->Command(*task);
  run::RunScript(*task, script, [&] {
    if (scenario) scenario->Take(*task);
    if (task->Now().sample.model_fault) return false;
    write();
    return true;
  });
  if (output) output->Finish();
  std::cerr << run::FinishRecording(recorder.get(), options.recording.directory, task->Now(),
                                    run::JudgeRun(task->Now(), 0).Text());
  const int status = Report(task->Now().sample);
  return scenario ? options.scenario.Report(scenario->What(), scenario->Judge(*task)) : status;
}

}  // namespace

void AddSimulateCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App& command =
      *program.add_subcommand("simulate", "Simulates from the steady state, as fast as it goes, to CSV");
  AddOptions(command, options->configuration);
  command
      .add_option("--x3", options->x3_in, "piston position of the steady state [in]; default: start.x3_in")
      ->type_name("IN");
  CLI::Option* with_scenario = AddOptions(command, options->scenario);
  CLI::Option* duration = command.add_option("--duration", options->duration_s, "simulated time [s]");
  duration->type_name("S")->excludes(with_scenario)->check(CLI::Range(model::kTickS, 1e6));
  auto* step = command.add_option("--p1-step", options->p1_step_psi,
                                  "step of the control oil pressure at t = 0 [psi]; default: none");
  step->type_name("PSI")->excludes(with_scenario)->check(CLI::Range(-1000.0, 1000.0));
  command
      .add_option(
          "--p1-file", options->p1_file,
          "control oil pressure over time: CSV t_s,p1_psi; each value holds from the first tick at or after "
          "its time")
      ->type_name("CSV")
      ->excludes(step)
      ->excludes(with_scenario);
  command.add_option("--every", options->every_ticks, "writes every n-th tick of 0.1 ms; default: 1")
      ->type_name("TICKS")
      ->check(CLI::Range(1, 1'000'000'000));
  command
      .add_option("-o,--output", options->output,
                  "CSV file; -: standard output; default: - unless it is recorded, or a scenario")
      ->type_name("FILE");
  AddOptions(command, options->recording);
  command.callback([options, duration, with_scenario, &exit_status] {
    if (duration->empty() && with_scenario->empty())
      throw base::UsageError("simulate: --duration S or --scenario FILE is required; --help tells more");
    exit_status = Simulate(*options);
  });
}

}  // namespace servohil::commands
