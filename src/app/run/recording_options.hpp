#pragma once
/// What a run is to record, and the recorder for it.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "servohil/app/contract.hpp"
#include "servohil/app/recording/recorder.hpp"
#include "servohil/app/simulation_task.hpp"

namespace servohil::app {

struct RecordingOptions {
  std::filesystem::path directory;  ///< empty: nothing is recorded
  int every_ticks = 1;

  /// @param real_time  never waits for the disk; else nothing is lost
  /// @param from  where the run begins; nothing: at rest
  std::unique_ptr<Recorder> Open(const RunTexts& texts, const Contract& contract, const std::string& clock,
                                 const std::optional<Snapshot>& from,
                                 const std::vector<std::string>& buses) const;
};

/// Ends a recording, if there is one. @return a line for the summary; empty without
std::string FinishRecording(Recorder* recorder, const std::filesystem::path& directory, const Telemetry& end,
                            const std::string& verdict);

}  // namespace servohil::app
