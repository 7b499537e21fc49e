#pragma once
/// A CAN controller by libsocketcan: its state and settings. link.hpp has the interface around it.
///
/// libsocketcan prints to standard error what it meets; here it stays silent, and what could not be done is
/// the result.

#include <cstdint>
#include <optional>
#include <string>

#include "can/error_frame.hpp"

namespace servohil::can {

inline constexpr double kSamplePointUnit =
    1000.0;  ///< the kernel counts sample points in thousandths of a bit

/// What a controller says; a virtual interface has none.
struct Controller {
  ControllerState state = ControllerState::kErrorActive;
  bool has_counters = false;   ///< the driver gives its error counters
  std::uint8_t tx_errors = 0;  ///< saturate at 255
  std::uint8_t rx_errors = 0;
  std::uint32_t bit_rate_bit_s = 0;
  double sample_point = 0.0;     ///< share of the bit; 0: not given
  std::uint32_t clock_hz = 0;    ///< that bits are made of; 0: not given
  std::uint32_t restart_ms = 0;  ///< after bus-off the kernel restarts it; 0: never
};

/// @return nothing where the interface has no controller, or is gone
std::optional<Controller> ReadController(const std::string& interface);

// All return whether the kernel took it; why not, only libmnl says (link.cpp).

/// @param sample_point  share of the bit; 0: the kernel's choice
bool SetBitTiming(const std::string& interface, std::uint32_t bit_rate_bit_s, double sample_point);
bool SetRestartMs(const std::string& interface, std::uint32_t restart_ms);
/// Restarts a controller that is bus-off.
bool Restart(const std::string& interface);
/// Takes any interface up or down.
bool SetUp(const std::string& interface, bool up);

}  // namespace servohil::can
