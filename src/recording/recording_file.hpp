#pragma once
/// What the recorder writes, without its thread: servohil.h5 and bus.log.
///
/// Single-writer-multiple-reader mode: every dataset exists before the first sample, and whoever opens the
/// file at any moment finds it consistent. Errors are EnvironmentErrors.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "recording/bus_log.hpp"
#include "recording/hdf5.hpp"
#include "recording/recorder.hpp"
#include "recording/recording.hpp"
#include "recording/table_writer.hpp"
#include "signal_map/signal_map.hpp"
#include "simulation/run_state.hpp"

namespace servohil::recording {

class RecordingFile {
 public:
  RecordingFile(const std::filesystem::path& directory, const RecordingAttributes& attributes,
                const signal_map::SignalMap& signal_map);

  /// @pre every stimulus up to the sample's tick has been added: no file holds a sample without them
  void Add(const simulation::RunState& run_state, std::int64_t now_ns);
  void Add(const Stimulus& stimulus, std::int64_t now_ns);
  void Add(const fault::Event& event, std::int64_t now_ns);
  void Add(const RecordingGap& gap, std::int64_t now_ns);
  void AddPublished(std::uint64_t tick, std::size_t message, const can::Frame& frame, std::int64_t now_ns);
  /// @param bus  of all of them, when nothing
  void AddToLog(std::int64_t time_ns, std::optional<std::size_t> bus, const can::Frame& frame);

  /// Writes what has waited long enough. @param all  everything, at once
  void Write(std::int64_t now_ns, bool all);

  std::uint64_t Samples() const noexcept { return samples_->Rows(); }
  std::uint64_t Stimuli() const noexcept { return stimuli_->Rows(); }
  std::uint64_t FaultEvents() const noexcept { return fault_events_->Rows(); }
  std::uint64_t Frames() const noexcept { return frames_; }

  /// Closes both, and opens servohil.h5 once more for the attributes of the end: single-writer mode takes no
  /// new ones.
  void Close(const std::optional<RecordingEnd>& end, const RecordingReport& report);
  /// After an error: leaves servohil.h5 as a kill would, readable up to the last flush. Closing it would try
  /// to write the rest, and spoil it half-way.
  void Abandon() noexcept;

 private:
  void CreateTables(const signal_map::SignalMap& signal_map, std::uint64_t every_ticks);
  void WriteSamples();
  void EndRow(TableWriter& table, std::int64_t now_ns);
  std::vector<TableWriter*> OtherTables();  ///< all but samples

  std::string name_;  ///< for errors
  std::vector<std::string> buses_;
  Id file_;
  std::optional<BusLog> log_;
  std::optional<TableWriter> samples_;
  std::optional<TableWriter> stimuli_;
  std::optional<TableWriter> fault_events_;
  std::optional<TableWriter> gaps_;
  struct PublishedTable {
    can::Message message;
    TableWriter table;
  };
  std::vector<PublishedTable> published_;
  std::uint64_t frames_ = 0;          ///< in the log
  std::uint64_t pending_frames_ = 0;  ///< on their way there
  bool flush_due_ = false;
  std::int64_t flushed_ns_ = 0;
};

}  // namespace servohil::recording
