#pragma once
/// A classical CAN or CAN FD frame, independent of any transport.

#include <array>
#include <cstdint>

namespace servohil::can {

struct Frame {
  std::uint32_t id = 0;          ///< identifier without flags: 11 bits, or 29 when extended
  bool extended = false;         ///< 29-bit identifier
  bool remote = false;           ///< remote transmission request: no data, `size` is the length asked for
  bool fd = false;               ///< CAN FD format
  bool bit_rate_switch = false;  ///< FD only: data phase at the second bit rate
  /// Nothing that was on the bus, but what the kernel tells of it: `id` holds the error classes, 8 data bytes
  /// the details (linux/can/error.h).
  bool error = false;
  std::uint8_t bus = 0;   ///< received: index of the bus in its network
  std::uint8_t size = 0;  ///< data bytes: 0 to 8, FD up to 64 (sent as 12, 16, 20, 24, 32, 48 or 64)
  std::array<std::uint8_t, 64> data{};
  std::int64_t receive_time_ns =
      0;  ///< CLOCK_REALTIME, from the kernel where it stamps; 0 for frames to send
};

}  // namespace servohil::can
