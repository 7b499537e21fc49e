#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "base/formatted.hpp"
#include "base/readable.hpp"
#include "commands/commands.hpp"
#include "commands/recording_options.hpp"
#include "commands/scenario_options.hpp"
#include "configuration/rest.hpp"
#include "model/ticks.hpp"
#include "run/candump.hpp"
#include "run/log_replay.hpp"
#include "run/replay.hpp"
#include "run/report.hpp"
#include "run/scripted_run.hpp"
#include "run/snapshot_file.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::commands {
namespace {

struct ReplayOptions {
  std::filesystem::path path;
  configuration::ConfigurationOptions configuration;
  std::optional<double> until_s;
  std::string interface;  ///< of a log; empty: the only one
  run::RecordingOptions recording;
  run::ScenarioOptions scenario;
};

using Count = unsigned long long;  // for printf

/// A run that is to be repeated: model, beginning, commands.
struct Rerun {
  configuration::Configuration configuration;
  std::optional<emulator::Snapshot> from;
  std::vector<recording::Stimulus> script;
  std::uint64_t end_tick = 0;
};

std::uint64_t EndTick(const ReplayOptions& options, std::uint64_t last_tick) {
  if (!options.until_s) return last_tick;
  const auto until = model::TicksOf(*options.until_s);
  return std::min(until, last_tick);
}

/// Runs it, recording if asked to; `after_tick(run_state)` as in RunScript. @return the end
template <typename AfterTick>
simulation::RunState RunAgain(const Rerun& rerun, const run::RecordingOptions& recording,
                              AfterTick&& after_tick) {
  const model::Derived derived(rerun.configuration.model);
  const model::SteadyState start =
      configuration::RequireSteadyStateAt(derived, rerun.configuration.start_x3_in);
  const signal_map::SignalMap signal_map(rerun.configuration);
  const auto recorder = recording.Open(configuration::DescribeConfiguration(rerun.configuration), signal_map,
                                       "fast", rerun.from, {});
  emulator::TaskOptions options;
  const std::uint64_t first_tick = rerun.from ? rerun.from->sample.tick : 0;
  if (rerun.end_tick <= first_tick)
    throw base::UsageError("replay: there is nothing to replay: not one tick was recorded");
  options.duration_ticks = rerun.end_tick - first_tick;
  options.safety = simulation::LawOf(rerun.configuration.safety);
  options.supervised = false;
  options.recorder = recorder.get();
  const auto task = std::make_unique<emulator::SimulationTask>(rerun.configuration.model, start, options);
  if (rerun.from) task->Restore(*rerun.from);
  run::RunScript(*task, rerun.script, [&] { return after_tick(task->Now()); });
  std::cout << run::FinishRecording(recorder.get(), recording.directory, task->Now(),
                                    run::JudgeRun(task->Now(), 0).Text());
  return task->Now();
}

/// The last tick of the run, or of what is left of it, up to which all stimuli are known.
std::uint64_t LastKnownTick(const recording::RecordingReader& recording) {
  std::uint64_t last = 0;
  std::vector<simulation::RunState> one(1);
  if (recording.SampleCount() > 0 && recording.ReadSamples(recording.SampleCount() - 1, one) == 1)
    last = one[0].sample.tick;
  if (recording.End()) last = std::max(last, recording.End()->final_tick);
  for (const recording::RecordingGap& gap : recording.Gaps()) {
    if (gap.stream != recording::RecordedStream::kStimuli || gap.tick > last) continue;
    std::cout << base::Formatted("commands or faults were lost at tick %llu: the replay ends there\n",
                                 Count{gap.tick});
    last = gap.tick - 1;
  }
  return last;
}

void TellWhatItIs(const recording::RecordingReader& recording) {
  const recording::RecordingAttributes& a = recording.Attributes();
  std::cout << "recording " << recording.File().string() << ": servohil " << a.program_version << ", "
            << a.clock << ", " << a.start_time << ", " << a.host << '\n';
  if (!recording.End()) {
    std::cout << "          it has no end: killed, or still being written\n";
  } else {
    std::cout << "          verdict " << recording.End()->verdict
              << (recording.Complete() ? "\n" : "; INCOMPLETE: something was lost\n");
  }
}

/// Whether the replay ends where the run did, but in another state: between recorded samples, too.
bool EndsDifferently(const recording::RecordingReader& recording, const simulation::RunState& end) {
  return recording.End() && recording.End()->final_tick == end.sample.tick &&
         recording.End()->final_state_hash != end.sample.state_hash;
}

int TellIdentity(const recording::RecordingReader& recording, const run::Comparison& comparison,
                 const simulation::RunState& end) {
  if (const auto& d = comparison.FirstDifference()) {
    std::cout << base::Formatted("differs from tick %llu (%.4f s) on: ", Count{d->tick},
                                 model::SecondsOf(d->tick))
              << d->variable << " recorded " << d->recorded << ", replayed " << d->replayed << '\n';
    return base::kExitNotValid;
  }
  if (EndsDifferently(recording, end)) {
    std::cout << base::Formatted(
        "differs at the end, tick %llu: state hash recorded %016llx, replayed %016llx\n",
        Count{end.sample.tick}, Count{recording.End()->final_state_hash}, Count{end.sample.state_hash});
    return base::kExitNotValid;
  }
  std::cout << base::Formatted("identical: %llu samples to tick %llu (%.4f s), state hash %016llx\n",
                               Count{comparison.ComparedSamples()}, Count{end.sample.tick},
                               model::SecondsOf(end.sample.tick), Count{end.sample.state_hash});
  return base::kExitOk;
}

void TellDeviations(const run::Comparison& comparison) {
  if (const auto& d = comparison.FirstDifference()) {
    std::cout << base::Formatted("deviates from tick %llu (%.4f s) on, first in ", Count{d->tick},
                                 model::SecondsOf(d->tick))
              << d->variable << "; largest deviations:\n";
  } else {
    std::cout << "the changes change nothing: identical\n";
  }
  for (const run::Deviation& d : comparison.LargestDeviations()) {
    std::cout << base::Formatted("  %-8s %.6g %s at %.4f s\n", d.variable.c_str(), d.largest, d.unit.c_str(),
                                 model::SecondsOf(d.tick));
  }
}

/// What is expected of a recorded run.
class ScenarioOfRecording {
 public:
  explicit ScenarioOfRecording(const scenario::ScenarioFile& file)
      : scenario_(file.UnderstandExpectations()), evaluation_(scenario_) {}
  static std::unique_ptr<ScenarioOfRecording> Open(const run::ScenarioOptions& options) {
    const auto file = options.Open();
    return file == nullptr ? nullptr : std::make_unique<ScenarioOfRecording>(*file);
  }

  void Take(const simulation::RunState& now) { evaluation_.Take(now); }
  int Report(const run::ScenarioOptions& options, std::vector<std::string> invalid_because) const {
    return options.Report(scenario_, evaluation_.Judge(std::move(invalid_because)));
  }

 private:
  const scenario::Scenario scenario_;
  scenario::Evaluation evaluation_;
};

/// The recorded run's own flaws. A what-if has no clock: the timing of the run that it departs from is not
/// its own.
std::vector<std::string> WhyRecordingIsInvalid(const recording::RecordingReader& recording, bool what_if) {
  std::vector<std::string> reasons;
  if (what_if) return reasons;
  if (!recording.Complete()) reasons.emplace_back("the recording is incomplete");
  std::vector<simulation::RunState> last(1);
  if (recording.SampleCount() == 0 || recording.ReadSamples(recording.SampleCount() - 1, last) != 1)
    return reasons;
  last[0].sample.model_fault = false;  // for the expectations to tell
  for (std::string& reason : run::JudgeRun(last[0], 0).reasons) reasons.push_back(std::move(reason));
  return reasons;
}

/// DIR beside the recording for the what-if: DIR-what-if, or the first of DIR-what-if-2, -3, ... that is
/// free.
std::filesystem::path WhatIfDirectory(std::filesystem::path recording) {
  if (std::filesystem::is_regular_file(recording)) recording = recording.parent_path();
  std::string base = std::filesystem::absolute(recording).lexically_normal().string();
  while (base.size() > 1 && base.back() == '/') base.pop_back();
  base += "-what-if";
  std::string name = base;
  for (int i = 2; std::filesystem::exists(name); ++i) name = base + "-" + std::to_string(i);
  return name;
}

int ReplayRecording(const ReplayOptions& options) {
  const recording::RecordingReader reader(options.path);
  TellWhatItIs(reader);
  const configuration::TemporaryConfiguration texts(reader.Attributes());
  Rerun rerun;
  rerun.configuration = configuration::LoadConfiguration(texts.File(), options.configuration.settings);
  if (const std::string& text = reader.Attributes().start_snapshot; !text.empty())
    rerun.from = run::ParseSnapshotText(text, reader.File().string());
  rerun.script = reader.Stimuli();
  rerun.end_tick = EndTick(options, LastKnownTick(reader));
  const bool what_if = !options.configuration.settings.empty();
  run::RecordingOptions recording = options.recording;
  if (what_if && recording.directory.empty()) recording.directory = WhatIfDirectory(options.path);

  const auto scenario = ScenarioOfRecording::Open(options.scenario);
  run::Comparison comparison(reader);
  const simulation::RunState end = RunAgain(rerun, recording, [&](const simulation::RunState& now) {
    comparison.Take(now);
    if (scenario) scenario->Take(now);
    return what_if || !comparison.FirstDifference();
  });
  if (what_if) {
    TellDeviations(comparison);
  } else if (const int status = TellIdentity(reader, comparison, end); status != base::kExitOk) {
    return status;
  }
  return scenario ? scenario->Report(options.scenario, WhyRecordingIsInvalid(reader, what_if))
                  : base::kExitOk;
}

/// Drives the model from any candump log, as a run on that bus would have been.
int ReplayLog(const ReplayOptions& options) {
  std::vector<run::LoggedFrame> logged = run::ReadCandump(options.path);
  if (logged.empty()) throw base::UsageError(options.path.string() + ": there is no frame in it");
  const configuration::Configuration configuration = options.configuration.Load();
  const signal_map::SignalMap signal_map(configuration);
  logged = run::FramesOfInterface(std::move(logged), options.interface, signal_map, options.path);
  const std::vector<run::FrameAfter> frames = run::OnTimeLine(logged, options.path);
  if (std::none_of(frames.begin(), frames.end(),
                   [&](const auto& one) { return signal_map.IsCommand(one.frame); })) {
    throw base::UsageError(options.path.string() +
                           base::Formatted(": there is no command frame in it: identifier 0x%X of ",
                                           signal_map.CommandMessage().id) +
                           signal_map.IncomingMessages().front().database->file);
  }
  const configuration::SafetySettings safety =
      configuration::Resolved(configuration.safety, signal_map.CommandCycleMs());
  const auto recorder = options.recording.Open(configuration::DescribeConfiguration(configuration),
                                               signal_map, "fast", std::nullopt, {});
  emulator::TaskOptions task_options;
  task_options.duration_ticks = EndTick(options, frames.back().ticks + 1);
  task_options.safety = simulation::LawOf(safety);
  task_options.recorder = recorder.get();
  const model::Derived derived(configuration.model);
  emulator::SimulationTask task(configuration.model,
                                configuration::RequireSteadyStateAt(derived, configuration.start_x3_in),
                                task_options);
  emulator::Receiver receiver(signal_map,
                              emulator::ValidatorOf(signal_map, safety, signal_map.CommandCycleMs(),
                                                    configuration.can.command.max_counter_jump),
                              task, nullptr, 1, emulator::FrameClock::kSimulated);
  run::RunLog(task, receiver, frames, [] { return true; });
  run::Verdict verdict = run::JudgeRun(task.Now(), 0);
  if (receiver.ValidCommands() == 0) verdict.reasons.emplace_back("no command was followed");
  std::cout << run::FinishRecording(recorder.get(), options.recording.directory, task.Now(), verdict.Text())
            << base::Formatted("log %s: %llu frames of %s, %.4f s\n", options.path.string().c_str(),
                               Count{frames.size()}, logged.front().interface.c_str(),
                               model::SecondsOf(frames.back().ticks))
            << "in       " << run::DescribeReceived(receiver.Counters()) << '\n'
            << run::SimulationSummary(task.Now())
            << base::Formatted("safety   %s (%s), %llu times lost, %llu trips\n",
                               simulation::NameOf(task.Now().status.safety),
                               simulation::NameOf(task.Now().status.safety_cause),
                               Count{task.Now().status.losses}, Count{task.Now().status.trips})
            << "verdict  " << verdict.Text() << '\n';
  return verdict.Valid() ? base::kExitOk : base::kExitNotValid;
}

int Replay(const ReplayOptions& options) {
  const bool directory = base::IsDirectory(options.path);
  if (!directory) base::RequireReadable(options.path);
  const bool recording = directory || options.path.extension() == ".h5";
  if (!recording && !options.scenario.file.empty())
    throw base::UsageError("replay: --scenario is for a recording, not for a log");
  if (recording && !options.configuration.file.empty())
    throw base::UsageError(
        "replay: a recording has its own configuration: --set changes single keys of it, -c is for logs");
  return recording ? ReplayRecording(options) : ReplayLog(options);
}

}  // namespace

void AddReplayCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App& command = *program.add_subcommand("replay",
                                              "Runs a recording again and compares, tick by tick, bit for "
                                              "bit; with --set: what if. Or drives the model "
                                              "from a candump log");
  command.add_option("path", options->path, "directory of a recording, or a candump log")
      ->type_name("DIR|LOG")
      ->required();
  AddOptions(command, options->configuration);
  command
      .add_option("--until", options->until_s, "ends at this simulated time [s]; default: with the recording")
      ->type_name("S")
      ->check(CLI::Range(model::kTickS, 1e9));
  command
      .add_option("--interface", options->interface,
                  "of a log: the interface that the governor is on; default: the only one with its messages")
      ->type_name("NAME");
  AddOptions(command, options->recording);
  AddOptions(command, options->scenario)
      ->description(
          "what this scenario (TOML) expects, held against the recording; its commands and faults are not "
          "used");
  command.callback([options, &exit_status] { exit_status = Replay(*options); });
}

}  // namespace servohil::commands
