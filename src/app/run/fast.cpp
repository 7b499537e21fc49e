#include "fast.hpp"

#include <iostream>
#include <memory>

#include "p1_script.hpp"
#include "report.hpp"
#include "scripted_run.hpp"
#include "servohil/app/run_texts.hpp"
#include "servohil/error.hpp"
#include "snapshot_writer.hpp"
#include "servohil/exit_status.hpp"

namespace servohil::app {

int RunFast(const RunOptions& options, const RunSetup& setup, const std::optional<Snapshot>& from,
            const StopSignals& signals) {
  if (options.script.empty() || options.duration_s == 0.0)
    throw UsageError("run: --clock fast needs --script FILE and --duration S");
  TaskOptions task_options = TaskOptionsOf(options, setup.configuration.loop);
  task_options.safety = LawOf(setup.configuration.safety);
  task_options.supervised = false;
  const std::vector<Influence> script = ReadP1Script(options.script);
  const RunTexts texts = DescribeConfiguration(setup.configuration);
  const auto recorder = options.recording.Open(texts, setup.contract, "fast", from, {});
  task_options.recorder = recorder.get();
  const auto task = std::make_unique<SimulationTask>(setup.configuration.model, setup.start, task_options);
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
  return verdict.Valid() ? kExitOk : kExitNotValid;
}

}  // namespace servohil::app
