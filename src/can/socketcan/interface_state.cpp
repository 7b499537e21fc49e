#include "can/socketcan/interface_state.hpp"

#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cstring>

#include "can/bus_monitor.hpp"
#include "can/file_descriptor.hpp"
#include "can/socketcan/link.hpp"

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

}  // namespace

bool IsCanInterface(const std::string& name) noexcept {
  const std::optional<ifreq> answer = Ask(name, SIOCGIFHWADDR);
  return answer && answer->ifr_hwaddr.sa_family == ARPHRD_CAN;
}

bool IsInterfaceUp(const std::string& name) noexcept {
  const std::optional<ifreq> answer = Ask(name, SIOCGIFFLAGS);
  return answer && (static_cast<unsigned>(answer->ifr_flags) & static_cast<unsigned>(IFF_UP)) != 0;
}

std::optional<std::uint32_t> InterfaceBitRate(const std::string& name) {
  const std::optional<Link> link = ReadLink(name);
  if (!link || !link->up || !link->controller || link->controller->bit_rate_bit_s == 0) return std::nullopt;
  return link->controller->bit_rate_bit_s;
}

std::string DescribeInterface(const std::string& name) {
  if (!IsCanInterface(name)) return "gone";
  if (!IsInterfaceUp(name)) return "down";
  const std::optional<Link> link = ReadLink(name);
  if (!link) return "up";
  if (link->IsVirtual()) return "up, virtual";
  if (!link->controller) return "up, state unknown";
  const Controller& controller = *link->controller;
  return "up, " + std::to_string(controller.bit_rate_bit_s) + " bit/s, " +
         NameOf(static_cast<BusState>(controller.state));
}

}  // namespace servohil::can
