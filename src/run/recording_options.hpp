#pragma once
/// What a run is to record, and the recorder for it.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "emulator/simulation_task.hpp"
#include "recording/recorder.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::run {

struct RecordingOptions {
  std::filesystem::path directory;  ///< empty: nothing is recorded
  int every_ticks = 1;

  /// @param real_time  never waits for the disk; else nothing is lost
  /// @param from  where the run begins; nothing: at rest
  std::unique_ptr<recording::Recorder> Open(const configuration::RunTexts& texts,
                                            const signal_map::SignalMap& signal_map, const std::string& clock,
                                            const std::optional<emulator::Snapshot>& from,
                                            const std::vector<std::string>& buses) const;
};

/// Ends a recording, if there is one. @return a line for the summary; empty without
std::string FinishRecording(recording::Recorder* recorder, const std::filesystem::path& directory,
                            const simulation::RunState& end, const std::string& verdict);

}  // namespace servohil::run
