#pragma once
/// Names of the root attributes, for writer and reader.

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/formatted.hpp"

namespace servohil::recording {

/// Raised when an older program would misread a recording. This one reads all since the oldest: columns that
/// were added later have defaults.
inline constexpr std::uint64_t kRecordingFormat = 3;  // governor's frames and supervision among the stimuli
inline constexpr std::uint64_t kOldestRecordingFormat = 2;

namespace attribute {

inline constexpr const char* kFormat = "servohil_recording";
inline constexpr const char* kConfiguration = "configuration";
inline constexpr const char* kHash = "configuration_fnv1a_64";
inline constexpr const char* kDbc = "dbc";
inline constexpr const char* kLoad = "load_curve";
inline constexpr const char* kLoadClosing = "load_closing";
inline constexpr const char* kStartSnapshot = "start_snapshot";
inline constexpr const char* kProgramVersion = "program_version";
inline constexpr const char* kClock = "clock";
inline constexpr const char* kBuses = "buses";
inline constexpr const char* kHost = "host";
inline constexpr const char* kStartTime = "start_time";
inline constexpr const char* kTick = "tick_s";
inline constexpr const char* kEveryTicks = "every_ticks";
inline constexpr const char* kFaults = "faults";
// Only at the end:
inline constexpr const char* kEndTime = "end_time";
inline constexpr const char* kVerdict = "verdict";
inline constexpr const char* kFinalStateHash = "final_state_hash";
inline constexpr const char* kFinalTick = "final_tick";
inline constexpr const char* kSamplesLost = "samples_lost";
inline constexpr const char* kInfluencesLost = "influences_lost";
inline constexpr const char* kFramesLost = "frames_lost";
inline constexpr const char* kProblem = "problem";
inline constexpr const char* kComplete = "complete";

/// Of the DBC file at this place of can.dbc: "dbc", "dbc_2", ...
inline std::string Dbc(std::size_t index) {
  return index == 0 ? attribute::kDbc : std::string(attribute::kDbc) + "_" + std::to_string(index + 1);
}

}  // namespace attribute

}  // namespace servohil::recording
