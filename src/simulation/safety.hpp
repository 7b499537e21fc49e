#pragma once
/// The command's supervision in plain words and structs: PROTOCOL.md has the figure.

#include <array>
#include <cstddef>
#include <cstdint>

namespace servohil::simulation {

/// What the run does with the governor's command.
enum class SafetyState : std::uint8_t {
  kWaiting = 0,   ///< at rest until the first command
  kRunning = 1,   ///< follows the newest valid command
  kDegraded = 2,  ///< the command is lost or not enabled: safety.on_loss
  kTripped = 3,   ///< P1 is drained at once
  kFaulted = 4,   ///< the model left its domain; until the end of the run
};
inline constexpr const char* kSafetyStateNames[] = {"waiting", "running", "degraded", "tripped", "faulted"};

/// Why it came to be in its state.
enum class SafetyCause : std::uint8_t {
  kNone = 0,
  kCommand = 1,        ///< the first valid command
  kOperator = 2,       ///< P1 set locally: control socket or script
  kSilence = 3,        ///< no command frame within safety.timeout_ms
  kInvalidFrames = 4,  ///< command frames within safety.timeout_ms, none of them valid
  kDisabled = 5,       ///< the enable signal is off
  kTrip = 6,           ///< the trip signal is on
  kRecovered = 7,      ///< safety.recover_after valid frames in a row
  kModelFault = 8,
};
inline constexpr const char* kSafetyCauseNames[] = {
    "nothing yet", "first command", "P1 set locally",       "no command frame",     "no valid command",
    "not enabled", "trip",          "valid commands again", "model left its domain"};

inline const char* NameOf(SafetyState state) noexcept {
  return kSafetyStateNames[static_cast<std::size_t>(state)];
}
inline const char* NameOf(SafetyCause cause) noexcept {
  return kSafetyCauseNames[static_cast<std::size_t>(cause)];
}

/// The first tick in another state.
struct SafetyChange {
  std::uint64_t tick = 0;
  SafetyState from = SafetyState::kWaiting;
  SafetyState to = SafetyState::kWaiting;
  SafetyCause cause = SafetyCause::kNone;
};

/// What a frame with the command's identifier was.
enum class FrameVerdict : std::uint8_t {
  kValid,
  kMalformed,   ///< too short, or a remote frame
  kOutOfRange,  ///< P1 outside the DBC's or the configured range, or not a number
  kTooFast,     ///< P1 changed faster than safety.p1_rate_psi_s
  kStale,       ///< older than safety.max_age_ms when it was read
  kCorrupted,   ///< end-to-end protection, as can::E2eVerdict; also the following
  kRepeated,
  kStuck,
  kReordered,
  kJumped,          ///< more were lost before it than are tolerated
  kNotAvailable,    ///< P1 is "not available" by J1939
  kErrorIndicator,  ///< P1 is the error indicator of J1939
};
inline constexpr const char* kFrameVerdictNames[] = {
    "commands", "malformed", "out_of_range", "too_fast", "stale",         "corrupted",
    "repeated", "stuck",     "reordered",    "jumped",   "not_available", "error_indicator"};
inline constexpr std::size_t kFrameVerdicts = std::size(kFrameVerdictNames);

inline const char* NameOf(FrameVerdict verdict) noexcept {
  return kFrameVerdictNames[static_cast<std::size_t>(verdict)];
}

/// Command frames since the start.
struct FrameCounts {
  std::array<std::uint64_t, kFrameVerdicts> of{};  ///< by verdict
  std::uint64_t lost = 0;  ///< missing between those that came, as their counter tells

  std::uint64_t& Of(FrameVerdict verdict) noexcept { return of[static_cast<std::size_t>(verdict)]; }
  std::uint64_t Of(FrameVerdict verdict) const noexcept { return of[static_cast<std::size_t>(verdict)]; }
  std::uint64_t Valid() const noexcept { return Of(FrameVerdict::kValid); }
  std::uint64_t Rejected() const noexcept {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : of) sum += count;
    return sum - Valid();
  }
  /// Repeated, stuck, reordered, jumped.
  std::uint64_t OutOfSequence() const noexcept {
    return Of(FrameVerdict::kRepeated) + Of(FrameVerdict::kStuck) + Of(FrameVerdict::kReordered) +
           Of(FrameVerdict::kJumped);
  }
};

}  // namespace servohil::simulation
