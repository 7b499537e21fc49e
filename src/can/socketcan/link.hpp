#pragma once
/// A CAN interface as the kernel has it, and how it is set up. Not for the loop: a query may wait for an
/// adapter.
///
/// Controllers are libsocketcan's (controller.hpp). What it lacks comes from libmnl (netlink.hpp): the number
/// and the text of the kernel's refusals, the queue's length, the kind and index of an interface, its packet
/// counts and frame size.

#include <cstdint>
#include <optional>
#include <string>

#include "can/socketcan/controller.hpp"

namespace servohil::can {

struct Link {
  int index = 0;  ///< another one when the interface has been made anew
  bool is_can = false;
  bool up = false;
  bool takes_fd = false;  ///< CAN FD frames; a classic interface refuses them
  std::string kind;       ///< "vcan", "vxcan", "can": a controller, or a serial line's; empty: not told
  std::uint64_t rx_packets = 0;
  std::uint64_t tx_packets = 0;
  std::optional<Controller> controller;

  bool IsVirtual() const { return kind == "vcan" || kind == "vxcan"; }
};

/// @return nothing where there is no such interface, or no netlink
std::optional<Link> ReadLink(const std::string& name);

struct LinkSettings {
  std::uint32_t bit_rate_bit_s = 500'000;
  double sample_point = 0.875;     ///< share of the bit; 0: the kernel's choice
  std::uint32_t restart_ms = 100;  ///< 0: never
  std::uint32_t queue_length = 16;
};

/// "sudo ip link set can0 down; ...": the commands that do the same as ConfigureLink().
std::string ConfigureCommands(const std::string& name, const LinkSettings& settings);

/// How far from what was wanted a controller may be that cannot do just that. CAN 2.0 leaves 1.58 % at best
/// to all that makes two nodes differ; CiA 301 wants the sample point of 0.875 between 0.85 and 0.9.
inline constexpr double kMaxBitRateError = 0.005;
inline constexpr double kMaxSamplePointError = 0.025;

/// What is wrong with a bit timing: the kernel takes the nearest that the controller's clock divides to, and
/// only refuses what is 5 % off. Empty: nothing.
std::string BitTimingMismatch(const std::string& name, const Controller& told, const LinkSettings& wanted);

/// Takes the interface down, sets it up, takes it up; what its driver does not have (sample point, restart)
/// is left as it is. A virtual one is taken up.
/// @throws EnvironmentError with the commands for a person to say, where that is not permitted; with the keys
///         where the controller has no such bit timing (the interface is then left down); with the kernel's
///         reason where it refuses
void ConfigureLink(const std::string& name, const LinkSettings& settings);

enum class RestartResult : std::uint8_t { kDone, kNotPermitted, kRefused };
/// Restarts a controller that is bus-off; where its driver cannot, the interface is taken down and up.
RestartResult RestartLink(const std::string& name);
/// Takes the interface down and up: whatever its controller and its queue hold is gone.
RestartResult ResetLink(const std::string& name);

}  // namespace servohil::can
