#pragma once
/// What a recording holds besides its samples. Written by Recorder, read by RecordingReader.

#include <cstdint>
#include <string>
#include <vector>

#include "configuration/run_texts.hpp"
#include "simulation/request.hpp"

namespace servohil::recording {

inline constexpr const char* kRecordingFile = "servohil.h5";
inline constexpr const char* kBusLogFile = "bus.log";

/// Everything a run depends on, besides what came from outside, and where it ran.
struct RecordingAttributes : configuration::RunTexts {
  std::string start_snapshot;  ///< SnapshotText() of where the run began; empty: at rest at start.x3_in
  std::string program_version;
  std::string clock = "real time";     ///< or "lockstep", "fast"
  std::vector<std::string> buses;      ///< names for bus.log: "vcan0"; no blanks
  std::uint64_t every_ticks = 1;       ///< samples: every so many ticks
  std::string host;                    ///< set by the recorder: system, name, release, machine
  std::string start_time;              ///< set by the recorder: UTC, ISO 8601
  std::string configuration_fnv1a_64;  ///< set by the recorder: ConfigurationHash(), 16 hexadecimal digits
};

/// Something from outside, with the first tick that feels it.
struct Stimulus {
  std::uint64_t tick = 0;
  simulation::Request request{};  ///< any but kSnapshot; its number is not recorded
};

/// What a gap is a gap in.
enum class RecordedStream : std::uint8_t { kSamples = 0, kStimuli = 1, kReceivedFrames = 2, kSentFrames = 3 };

/// Items that never reached the file: the disk was too slow or full.
struct RecordingGap {
  RecordedStream stream = RecordedStream::kSamples;
  std::uint64_t tick = 0;  ///< of the first one lost; of received frames: about
  std::uint64_t lost = 0;  ///< how many
  friend bool operator==(const RecordingGap&, const RecordingGap&) = default;
};

/// What only the end of a run tells.
struct RecordingEnd {
  std::string verdict;  ///< "VALID", "INVALID: ..."
  std::uint64_t final_state_hash = 0;
  std::uint64_t final_tick = 0;  ///< of the run, recorded or not; 0: recorded by a program that did not say
};

}  // namespace servohil::recording
