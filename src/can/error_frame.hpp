#pragma once
/// Error frames: what the kernel tells of the controller and of disturbances on the bus. Nothing here throws.

#include <array>
#include <cstdint>
#include <string>

#include "can/frame.hpp"

namespace servohil::can {

/// Error state of a controller, ISO 11898-1: by its error counters, from 96, 128 and 256 on.
enum class ControllerState : std::uint8_t { kErrorActive, kErrorWarning, kErrorPassive, kBusOff };

/// What the error frames of one bus have told since the start. Trivially copyable.
struct ErrorTotals {
  std::uint64_t frames = 0;
  std::uint64_t disturbances = 0;              ///< bit, stuff, form, CRC errors: frames that were destroyed
  std::uint64_t missing_acknowledgements = 0;  ///< frames of ours that nobody acknowledged
  std::uint64_t controller_overflows = 0;      ///< the controller's own buffers
  std::uint64_t bus_offs = 0;
  std::uint64_t restarts = 0;
  ControllerState state = ControllerState::kErrorActive;  ///< as told last
  std::uint8_t tx_errors = 0;                             ///< error counters, as told last; saturate at 255
  std::uint8_t rx_errors = 0;
  std::uint32_t last_classes = 0;  ///< the newest error frame
  std::array<std::uint8_t, 8> last_data{};

  /// @param error  an error frame
  void Take(const Frame& error) noexcept;
  /// The newest one in the words of candump -e: "controller-problem{tx-error-passive},
  /// protocol-violation{bit-stuffing, on-transmission}{data}, no-acknowledgement". Empty: none yet.
  std::string DescribeLast() const;
};

}  // namespace servohil::can
