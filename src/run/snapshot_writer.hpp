#pragma once
/// From the snapshots that a run has taken to files.

#include <spdlog/spdlog.h>

#include <filesystem>
#include <utility>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "run/snapshot_file.hpp"

namespace servohil::run {

/// Writes down the snapshots that were taken, as snapshot-TICK.json.
class SnapshotWriter {
 public:
  SnapshotWriter(std::filesystem::path directory, configuration::RunTexts texts)
      : directory_(std::move(directory)), texts_(std::move(texts)) {}

  /// @param source  an Emulator or a SimulationTask
  template <typename Source>
  void WriteAll(Source& source) const {
    emulator::Snapshot snapshot;
    while (source.TryPopSnapshot(snapshot)) {
      const auto file = directory_ / base::Formatted("snapshot-%llu.json",
                                                     static_cast<unsigned long long>(snapshot.sample.tick));
      WriteSnapshot(file, {SERVOHIL_VERSION, snapshot, texts_});
      spdlog::info("snapshot: {}", file.string());
    }
  }

  /// The same for a run that must go on: one that cannot be written is told and given up.
  template <typename Source>
  void WriteAllOrTell(Source& source) const {
    try {
      WriteAll(source);
    } catch (const base::EnvironmentError& error) {
      spdlog::error("{}", error.what());
    }
  }

 private:
  std::filesystem::path directory_;
  configuration::RunTexts texts_;
};

}  // namespace servohil::run
