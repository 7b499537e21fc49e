#include "run/fast.hpp"

#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "configuration/run_texts.hpp"
#include "run/p1_script.hpp"
#include "run/report.hpp"
#include "run/scripted_run.hpp"
#include "run/snapshot_writer.hpp"

namespace servohil::run {

int RunFast(const RunOptions& options, const RunSetup& setup, const std::optional<emulator::Snapshot>& from,
            const StopSignals& signals) {
  if (options.script.empty() || options.duration_s == 0.0)
    throw base::UsageError("run: --clock fast needs --script FILE and --duration S");
  emulator::TaskOptions task_options = TaskOptionsOf(options, setup.configuration.loop);
  task_options.safety = simulation::LawOf(setup.configuration.safety);
  task_options.supervised = false;
  const std::vector<recording::Stimulus> script = ReadP1Script(options.script);
  const configuration::RunTexts texts = configuration::DescribeConfiguration(setup.configuration);
  const auto recorder = options.recording.Open(texts, setup.signal_map, "fast", from, {});
  task_options.recorder = recorder.get();
  const auto task =
      std::make_unique<emulator::SimulationTask>(setup.configuration.model, setup.start, task_options);
  if (from) task->Restore(*from);
  SnapshotWriter snapshots(options.snapshots, texts);
  RunScript(*task, script, [&] {
    snapshots.WriteAll(*task);
    return task->Now().sample.tick % 10'000 != 0 || signals.Next() == 0;
  });
  const Verdict verdict = JudgeRun(task->Now(), 0);
  std::cout << SimulationSummary(task->Now())
            << FinishRecording(recorder.get(), options.recording.directory, task->Now(), verdict.Text())
            << "verdict  " << verdict.Text() << std::endl;
  return verdict.Valid() ? base::kExitOk : base::kExitNotValid;
}

}  // namespace servohil::run
