#include "servohil/can/interface_state.hpp"

#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "file_descriptor.hpp"

extern "C" {
#include <libsocketcan.h>
}

namespace servohil::can {
namespace {

/// One SIOCGIF* request. Works on any socket, so also where the kernel knows no CAN.
std::optional<ifreq> Ask(const std::string& name, unsigned long request) noexcept {
  ifreq answer{};
  if (name.empty() || name.size() >= sizeof(answer.ifr_name)) return std::nullopt;
  std::memcpy(answer.ifr_name, name.c_str(), name.size() + 1);
  const FileDescriptor any_socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!any_socket || ::ioctl(any_socket.Get(), request, &answer) != 0) return std::nullopt;
  return answer;
}

/// vcan, vxcan, and what slcand makes: none of them has a bit rate to read. Unknown (no /sys) counts as
/// virtual: libsocketcan writes to the standard error when it is asked about an interface that has no
/// controller.
bool IsVirtual(const std::string& name) noexcept {
  try {
    std::error_code error;
    const std::filesystem::path device = std::filesystem::read_symlink("/sys/class/net/" + name, error);
    return error || device.string().find("/virtual/") != std::string::npos;
  } catch (...) {
    return true;
  }
}

bool HasController(const std::string& name) noexcept {
  return IsCanInterface(name) && IsInterfaceUp(name) && !IsVirtual(name);
}

std::string ControllerState(const std::string& name) {
  static constexpr std::array<const char*, CAN_STATE_MAX> kNames{
      "error-active", "error-warning", "error-passive", "bus-off", "stopped", "sleeping"};
  int state = 0;
  if (can_get_state(name.c_str(), &state) != 0 || state < 0 || state >= CAN_STATE_MAX) return "state unknown";
  return kNames[static_cast<std::size_t>(state)];
}

}  // namespace

bool IsCanInterface(const std::string& name) noexcept {
  const std::optional<ifreq> answer = Ask(name, SIOCGIFHWADDR);
  return answer && answer->ifr_hwaddr.sa_family == ARPHRD_CAN;
}

bool IsInterfaceUp(const std::string& name) noexcept {
  const std::optional<ifreq> answer = Ask(name, SIOCGIFFLAGS);
  return answer && (static_cast<unsigned>(answer->ifr_flags) & static_cast<unsigned>(IFF_UP)) != 0;
}

std::optional<std::uint32_t> InterfaceBitRate(const std::string& name) noexcept {
  can_bittiming timing{};
  if (!HasController(name) || can_get_bittiming(name.c_str(), &timing) != 0 || timing.bitrate == 0) {
    return std::nullopt;
  }
  return timing.bitrate;
}

std::string DescribeInterface(const std::string& name) {
  if (!IsCanInterface(name)) return "gone";
  if (!IsInterfaceUp(name)) return "down";
  if (IsVirtual(name)) return "up, virtual";
  const std::optional<std::uint32_t> bit_rate = InterfaceBitRate(name);
  return "up, " + (bit_rate ? std::to_string(*bit_rate) + " bit/s, " : std::string()) + ControllerState(name);
}

}  // namespace servohil::can
