#pragma once
/// What a recording holds besides its samples. Written by Recorder, read by RecordingReader.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "servohil/app/configuration.hpp"

namespace servohil::app {

inline constexpr const char* kRecordingFile = "servohil.h5";
inline constexpr const char* kBusLogFile = "bus.log";

/// Everything a run depends on, besides the commands.
struct RecordingAttributes {
  std::string configuration_toml;  ///< ConfigurationToml()
  std::string dbc;                 ///< the files' text
  std::string load_csv;
  std::string load_closing_csv;  ///< empty: one curve for both directions
  std::string program_version;
  std::string clock = "real time";     ///< or "lockstep", "fast"
  std::vector<std::string> buses;      ///< names for bus.log: "vcan0"; no blanks
  std::uint64_t every_ticks = 1;       ///< samples: every so many ticks
  std::string host;                    ///< set by the recorder: system, name, release, machine
  std::string start_time;              ///< set by the recorder: UTC, ISO 8601
  std::string configuration_fnv1a_64;  ///< set by the recorder: ConfigurationHash(), 16 hexadecimal digits
};

/// FNV-1a, 64 bits, over configuration, DBC and both load tables, each followed by a zero byte. Recordings
/// of the same hash ran the same model on the same contract. Not cryptographic.
/// Source: G. Fowler, L. C. Noll, K.-P. Vo, D. Eastlake, "The FNV Non-Cryptographic Hash Algorithm",
/// draft-eastlake-fnv.
std::uint64_t ConfigurationHash(const RecordingAttributes& attributes);

/// The configuration with the files that it names, as they are now.
/// @throws UsageError when one of them cannot be read
RecordingAttributes DescribeConfiguration(const Configuration& configuration);

/// Lays out servohil.toml, load_curve.csv, load_closing.csv (where there is one) and servohil.dbc in
/// `directory`, which is created: LoadConfiguration(directory / "servohil.toml", ...) gives the recorded one.
/// @return the path of servohil.toml
/// @throws EnvironmentError when a file cannot be written
std::filesystem::path WriteConfigurationDirectory(const RecordingAttributes& attributes,
                                                  const std::filesystem::path& directory);

/// A command with the first tick that used it.
struct RecordedCommand {
  std::uint64_t tick = 0;
  double p1_psi = 0.0;
  friend bool operator==(const RecordedCommand&, const RecordedCommand&) = default;
};

/// What a gap is a gap in.
enum class RecordedStream : std::uint8_t {
  kSamples = 0,
  kCommands = 1,
  kReceivedFrames = 2,
  kSentFrames = 3
};

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
};

}  // namespace servohil::app
