#pragma once
/// What faults act on besides the model's parameters, and how: plain structs that an act changes.

#include <cstdint>
#include <variant>

#include "fault/injection.hpp"
#include "fault/random.hpp"
#include "model/parameters.hpp"

namespace servohil::fault {

/// What a sensor says of a quantity. Not a number: the signal is not available; infinite: as much as it can
/// say. The signal_map makes raw values of both.
struct Reading {
  double value = 0.0;    ///< in the quantity's unit: the truth, or what the acts before have made of it
  double held = 0.0;     ///< what it was when this fault began
  double delayed = 0.0;  ///< truth values[0] seconds ago, but not from before this fault began
  double t_s = 0.0;      ///< since this fault began
};

/// What becomes of a frame that is published.
struct Transmission {
  bool lost = false;
  bool after_next = false;      ///< overtaken by the next one of its message
  bool counter_stuck = false;   ///< of its protection
  bool checksum_wrong = false;  ///< of its protection
  std::uint8_t copies = 1;
  std::uint8_t flipped_bits = 0;  ///< of its data: as many, chosen by
  std::uint64_t flip_key = 0;
  std::uint32_t delay_ticks = 0;
  friend bool operator==(const Transmission&, const Transmission&) = default;
};

/// What becomes of a frame that arrives.
struct Reception {
  bool lost = false;
  std::uint32_t delay_ticks = 0;
  friend bool operator==(const Reception&, const Reception&) = default;
};

/// The state of the wire.
struct Line {
  bool down = false;       ///< as if unplugged
  double babble_hz = 0.0;  ///< frames that nobody asked for
  std::uint32_t babble_id = 0;
  double errors_hz = 0.0;  ///< error frames
};

/// The machine is away from its work.
struct Stall {
  double ms = 0.0;
};

// `share` of it: 0 to 1, the ramp. All real-time safe.
using ParameterAct = void (*)(model::Parameters& p, const Values& v, double share, double t_s) noexcept;
using SensorAct = void (*)(Reading& r, const Values& v, double share, Random& random) noexcept;
using TransmitAct = void (*)(Transmission& t, const Values& v, double share, Random& random) noexcept;
using ReceiveAct = void (*)(Reception& r, const Values& v, double share, Random& random) noexcept;
using LineAct = void (*)(Line& line, const Values& v, double share) noexcept;
using StallAct = void (*)(Stall& stall, const Values& v) noexcept;  ///< once, at the start of each pulse

using Act = std::variant<ParameterAct, SensorAct, TransmitAct, ReceiveAct, LineAct, StallAct>;

}  // namespace servohil::fault
