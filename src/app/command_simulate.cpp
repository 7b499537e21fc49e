#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "servohil/app/csv.hpp"
#include "servohil/app/envelope_check.hpp"
#include "servohil/app/simulation.hpp"
#include "servohil/error.hpp"

namespace servohil::app {
namespace {

struct Options {
  ConfigurationOptions configuration;
  std::optional<double> x3_in;
  double duration_s = 0.0;
  std::optional<double> p1_step_psi;
  std::filesystem::path p1_file;
  int every_ticks = 1;
  std::string output = "-";
};

/// P1 over time: the steady state's, then each value from its tick on.
class P1Input {
 public:
  P1Input(double rest_psi, const Options& options) : p1_psi_(rest_psi) {
    if (options.p1_step_psi) changes_.push_back({0, rest_psi + *options.p1_step_psi});
    if (options.p1_file.empty()) return;
    double last_s = -1.0;
    for (const CsvRow& row : ReadCsv(options.p1_file, "t_s,p1_psi")) {
      if (!(row.values[0] > last_s) || row.values[0] < 0.0) {
        throw UsageError(options.p1_file.string() + ":" + std::to_string(row.line) +
                         ": t_s must be 0 or more and rise from row to row");
      }
      last_s = row.values[0];
      // A time meant for a tick may lie beside it by rounding of its decimals.
      const double ticks = std::ceil(row.values[0] / model::kTickS - 1e-6);
      changes_.push_back({static_cast<std::uint64_t>(ticks), row.values[1]});
    }
  }

  /// For the tick that begins after `tick` ticks; call with rising ticks.
  double For(std::uint64_t tick) {
    while (next_ < changes_.size() && changes_[next_].tick <= tick) p1_psi_ = changes_[next_++].p1_psi;
    return p1_psi_;
  }

 private:
  struct Change {
    std::uint64_t tick;
    double p1_psi;
  };
  std::vector<Change> changes_;
  std::size_t next_ = 0;
  double p1_psi_;
};

/// CSV with every bit of every number. Throws when the disk does not take it.
class CsvOutput {
 public:
  explicit CsvOutput(const std::string& path)
      : path_(path), file_(path == "-" ? stdout : std::fopen(path.c_str(), "w")) {
    if (file_ == nullptr) throw EnvironmentError(path + ": cannot be written");
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

  void Write(const Sample& s, const model::Outputs& o) {
    const double values[] = {static_cast<double>(s.tick) * model::kTickS,
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
      throw EnvironmentError((path_ == "-" ? "standard output" : path_) + ": writing failed (disk full?)");
  }

 private:
  std::string path_;
  std::FILE* file_;
};

int Simulate(const Options& options) {
  const Configuration configuration = options.configuration.Load();
  const model::Derived derived(configuration.model);
  if (const std::string warning = CheckEnvelope(configuration, derived); !warning.empty())
    std::fprintf(stderr, "servohil: %s\n", warning.c_str());
  const double x3_in = options.x3_in.value_or(configuration.start_x3_in);
  const model::SteadyState start = RequireSteadyStateAt(derived, x3_in);
  const auto ticks = static_cast<std::uint64_t>(std::llround(options.duration_s / model::kTickS));
  const auto every = static_cast<std::uint64_t>(options.every_ticks);

  P1Input p1(start.p1_psi, options);
  Simulation simulation(derived, start);
  CsvOutput output(options.output);
  output.Write(simulation.Now(), simulation.OutputsAt(simulation.Now()));
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const Sample& sample = simulation.Tick(p1.For(tick));
    if (sample.model_fault) {
      output.Finish();
      std::fprintf(
          stderr,
          "servohil: model fault at t = %.4f s: the state left the model's domain after x3 = %.6g in, "
          "P3 = %.6g psi; the output ends there\n",
          static_cast<double>(sample.tick) * model::kTickS, sample.state.x3_in, sample.state.p3_psi);
      return kExitNotValid;
    }
    if (sample.tick % every == 0) output.Write(sample, simulation.OutputsAt(sample));
  }
  output.Finish();
  if (const std::uint64_t unresolved = simulation.Now().unresolved_ticks; unresolved > 0) {
    std::fprintf(stderr,
                 "servohil: %llu of %llu ticks were faster than %d sub-steps resolve: less accurate there\n",
                 static_cast<unsigned long long>(unresolved), static_cast<unsigned long long>(ticks),
                 model::kMaxSubSteps);
  }
  return kExitOk;
}

}  // namespace

void AddSimulateCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<Options>();
  CLI::App& command =
      *program.add_subcommand("simulate", "Simulates from the steady state, as fast as it goes, to CSV");
  options->configuration.AddTo(command);
  command
      .add_option("--x3", options->x3_in, "piston position of the steady state [in]; default: start.x3_in")
      ->type_name("IN");
  command.add_option("--duration", options->duration_s, "simulated time [s]")
      ->type_name("S")
      ->required()
      ->check(CLI::Range(model::kTickS, 1e6));
  auto* step = command.add_option("--p1-step", options->p1_step_psi,
                                  "step of the control oil pressure at t = 0 [psi]; default: none");
  step->type_name("PSI")->check(CLI::Range(-1000.0, 1000.0));
  command
      .add_option(
          "--p1-file", options->p1_file,
          "control oil pressure over time: CSV t_s,p1_psi; each value holds from the first tick at or after "
          "its time")
      ->type_name("CSV")
      ->excludes(step);
  command.add_option("--every", options->every_ticks, "writes every n-th tick of 0.1 ms; default: 1")
      ->type_name("TICKS")
      ->check(CLI::Range(1, 1'000'000'000));
  command.add_option("-o,--output", options->output, "CSV file; - (default): standard output")
      ->type_name("FILE");
  command.callback([options, &exit_status] { exit_status = Simulate(*options); });
}

}  // namespace servohil::app
