#pragma once
/// Records a run: DIR/servohil.h5 (HDF5, readable while it grows and after a kill) and DIR/bus.log (candump).
/// PROTOCOL.md, "Recording", has the layout.
///
///   [sim] ─ samples, stimuli ▶ rings ┐
///   [can_rx] ─ frames ▶ ring ─────────┼▶ [recorder] ─▶ disk
///   [can_tx] ─ frames ▶ ring ─────────┘
///
/// A disk that is slow or full never delays a producer: what finds its ring full (a little more than 3 s of
/// samples) is lost, counted and marked as a gap; the recording is then incomplete, the run is not touched.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "can/frame.hpp"
#include "recording/recording.hpp"
#include "signal_map/signal_map.hpp"
#include "simulation/run_state.hpp"

namespace servohil::recording {

/// Bytes that the file system of `directory` has left for this user. @throws EnvironmentError
std::uint64_t FreeBytes(const std::filesystem::path& directory);

struct RecorderOptions {
  /// Recording ends before the file system has less than this left, so that the file can be closed: a round
  /// of the writer's takes at most 2 MB.
  std::uint64_t reserve_bytes = 4U << 20U;
  /// Faster than real time: a producer whose ring is full sleeps until there is room, and nothing is lost.
  bool producers_wait = false;
  std::uint64_t (*free_bytes)(const std::filesystem::path& directory) = FreeBytes;  ///< for the tests
};

/// What became of a recording.
struct RecordingReport {
  bool complete = true;       ///< nothing was lost
  std::string problem;        ///< one line; empty when complete
  std::uint64_t samples = 0;  ///< on file
  std::uint64_t stimuli = 0;  ///< on file: commands and faults
  std::uint64_t frames = 0;   ///< in bus.log; a frame sent on several buses counts once
  std::uint64_t samples_lost = 0;
  std::uint64_t stimuli_lost = 0;
  std::uint64_t frames_lost = 0;
  double writer_cpu_s = 0.0;  ///< CPU time of the writer thread
};

class Recorder {
 public:
  /// Creates the directory (if need be) and both files, and starts the writer thread.
  /// @throws UsageError when the directory holds a recording already, EnvironmentError when it cannot be
  ///         written or the disk is full
  Recorder(const std::filesystem::path& directory, const RecordingAttributes& attributes,
           const signal_map::SignalMap& signal_map, const RecorderOptions& options = {});
  /// As Finish() without an end: like a killed recording, but with nothing lost.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  // Simulation thread. Wait-free, real-time safe (unless producers_wait).
  /// Takes it when its tick is a multiple of every_ticks.
  void RecordTick(const simulation::RunState& run_state) noexcept;
  /// An stimulus from outside with the first tick that uses it; before RecordTick() of that tick.
  void RecordStimulus(const Stimulus& stimulus) noexcept;
  /// What has happened to a fault.
  void RecordFaultEvent(const fault::Event& event) noexcept;

  /// Receiver thread. Wait-free, real-time safe. @param bus  index into RecordingAttributes::buses
  void RecordReceived(const can::Frame& frame, std::size_t bus) noexcept;
  /// Sender thread. Wait-free, real-time safe. @param message  kMaxMessages: none that is published @param
  /// tick  whose state the frame carries
  void RecordSent(std::uint64_t tick, std::size_t message, const can::Frame& frame) noexcept;

  /// Any thread: something has been lost.
  bool Incomplete() const noexcept;

  /// After the producers have ended: writes what is left and the end, and closes. Idempotent.
  RecordingReport Finish(const RecordingEnd& end) noexcept;

 private:
  class Writer;
  std::unique_ptr<Writer> writer_;
};

}  // namespace servohil::recording
