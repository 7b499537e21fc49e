#pragma once
/// What the configuration says about the frames of a run: [can.command] and [[can.publish]]. Names of the DBC
/// files' messages and signals, not yet looked up.

#include <optional>
#include <string>
#include <vector>

#include "can/e2e/e2e.hpp"

namespace servohil::configuration {

struct ScalePoint {
  double from = 0.0;
  double to = 0.0;

  bool operator==(const ScalePoint&) const = default;
};
/// A straight line through two points, as [[4.0, 0.0], [20.0, 150.0]]; empty: none.
using Scale = std::vector<ScalePoint>;

/// End-to-end protection of a message; its signals by name.
struct ProtectionSettings {
  can::E2eProfile profile = can::E2eProfile::kNone;
  int data_id = can::kNoDataId;
  can::DataIdMode data_id_mode = can::DataIdMode::kBoth;
  std::string counter;   ///< empty: where the profile has it
  std::string checksum;  ///< the same
};

inline std::span<const char* const> NamesOf(can::E2eProfile) {
  return can::kE2eProfileNames;
}
inline std::span<const char* const> NamesOf(can::DataIdMode) {
  return can::kDataIdModeNames;
}

inline constexpr int kDefaultCycleMs = 10;  ///< of the command, where neither key nor DBC file has one

/// [can.command]: the governor's frames. A signal is written "MESSAGE.SIGNAL".
struct CommandSettings {
  std::string p1 = "GOV_Command.P1_Demand";
  std::string unit;               ///< of P1; empty: as the DBC file says
  Scale scale;                    ///< from the signal's value to psi, instead of a unit
  bool may_clip = false;          ///< the signal need not reach from closed to open
  std::string enable;             ///< true while not 0, or "MESSAGE.SIGNAL = VALUE"; empty: always enabled
  std::string trip;               ///< the same; empty: never tripped
  bool pgn = false;               ///< J1939: whatever the source address and the priority
  int cycle_ms = 0;               ///< expected of the governor; 0: as the DBC file says, else kDefaultCycleMs
  ProtectionSettings protection;  ///< of the message with P1
  int max_counter_jump = 1;       ///< largest step of its counter that is valid: 1 tolerates no loss
};

/// What goes into one signal: an emulator quantity, or a constant.
struct SignalSettings {
  std::string signal;
  std::string quantity;            ///< "x3_in"; empty: a constant
  std::string unit;                ///< of the signal; empty: as the DBC file says
  Scale scale;                     ///< from the quantity (in its own unit) to the signal's value, instead
  bool may_clip = false;           ///< the signal need not hold the whole stroke
  std::optional<double> constant;  ///< physical value
  std::optional<long long> raw;    ///< constant raw value
  std::string place;               ///< "FILE:LINE"
};

/// [[can.publish]]: a message of the emulator's.
struct MessageSettings {
  std::string message;
  int cycle_ms = 0;        ///< 0: as the DBC file says (GenMsgCycleTime)
  bool on_change = false;  ///< sent when its bits differ from the frame before, looked at every cycle_ms
  /// Those that are left out have their start value (GenSigStartValue). All left out: each signal has the
  /// name of a quantity.
  std::vector<SignalSettings> signals;
  std::string place;  ///< "FILE:LINE"
  ProtectionSettings protection;
};

}  // namespace servohil::configuration
