#pragma once
/// Section [safety] of the configuration.

#include <cstdint>
#include <span>

namespace servohil::configuration {

/// What becomes of P1 when the command is lost.
enum class OnLoss : std::uint8_t { kHold, kDrain, kFreeze };

inline std::span<const char* const> NamesOf(OnLoss) {
  static constexpr const char* kNames[] = {"hold", "drain", "freeze"};
  return kNames;
}

struct SafetySettings {
  int timeout_ms = -1;  ///< without a valid command; 0: never; -1: three times the governor's cycle
  bool timeout_is_of_cycle = false;  ///< set by Resolved(): it was not given
  OnLoss on_loss = OnLoss::kDrain;
  double drain_time_constant_s = 0.5;
  double trip_time_constant_s = 0.05;
  int recover_after = 3;  ///< valid frames in a row
  int max_age_ms = 20;    ///< of a frame when it is read; 0: any
  double p1_minimum_psi = 0.0;
  double p1_maximum_psi = 300.0;
  double p1_rate_psi_s = 0.0;  ///< 0: any
};

/// With the time-out in the governor's cycles made one in ms.
inline SafetySettings Resolved(SafetySettings settings, int command_cycle_ms) noexcept {
  constexpr int kCycles = 3;
  settings.timeout_is_of_cycle = settings.timeout_ms < 0;
  if (settings.timeout_ms < 0) settings.timeout_ms = kCycles * command_cycle_ms;
  return settings;
}

}  // namespace servohil::configuration
