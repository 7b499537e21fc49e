#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "base/error.hpp"
#include "can/socketcan/interface_state.hpp"
#include "can/socketcan/socketcan.hpp"

namespace servohil::can {
namespace {

std::string ErrorText(int error) {
  return std::generic_category().message(error);
}

bool IsVirtualName(const std::string& interface) {
  return interface.rfind("vcan", 0) == 0 || interface.rfind("vxcan", 0) == 0;
}

std::string SetUpCommand(const std::string& interface, const BusOptions& options) {
  if (IsVirtualInterface(interface)) return "sudo ip link set " + interface + " up";
  return "sudo ip link set " + interface + " up type can bitrate " + std::to_string(options.bit_rate_bit_s);
}

std::string SetUpForFdCommand(const std::string& interface, const BusOptions& options) {
  const std::string set = "sudo ip link set " + interface;
  if (IsVirtualInterface(interface)) return "this changes it: " + set + " mtu 72";
  return "where its controller can: " + set + " down; " + SetUpCommand(interface, options) + " dbitrate " +
         std::to_string(options.data_bit_rate_bit_s) + " fd on";
}

void SetOption(int socket, int level, int option, int value, const char* called) {
  if (::setsockopt(socket, level, option, &value, sizeof value) != 0) {
    throw base::EnvironmentError(std::string("the kernel refuses the CAN socket option ") + called + ": " +
                                 ErrorText(errno));
  }
}

}  // namespace

std::vector<can_filter> KernelFilters(const std::vector<WantedId>& wanted) {
  if (wanted.empty()) return {can_filter{0, 0}};
  std::vector<can_filter> filters;
  filters.reserve(wanted.size());
  for (const WantedId& id : wanted) {
    // The flags are part of the comparison: a remote frame, or the same number in the other format, is
    // another.
    const canid_t flags = CAN_EFF_FLAG | CAN_RTR_FLAG;
    filters.push_back({id.extended ? (id.id | CAN_EFF_FLAG) : id.id,
                       flags | (id.mask & (id.extended ? CAN_EFF_MASK : CAN_SFF_MASK))});
  }
  return filters;
}

bool IsVirtualInterface(const std::string& interface) {
  const std::optional<Link> link = ReadLink(interface);
  return link && !link->kind.empty() ? link->IsVirtual() : IsVirtualName(interface);
}

void CheckInterface(const std::string& interface, const BusOptions& options) {
  if (::if_nametoindex(interface.c_str()) == 0) {
    if (IsVirtualName(interface)) {
      throw base::EnvironmentError("no CAN interface " + interface + "; make it: sudo ip link add dev " +
                                   interface + " type vcan && sudo ip link set up " + interface);
    }
    throw base::EnvironmentError(
        "no such interface " + interface +
        ": is the adapter plugged in? This lists what there is: ip -br link show type can");
  }
  if (!IsCanInterface(interface)) {
    throw base::EnvironmentError(interface +
                                 " is not a CAN interface; this lists them: ip -br link show type can");
  }
  if (!options.allow_physical && !IsVirtualInterface(interface)) {
    throw base::UsageError(PhysicalRefusal("socketcan:" + interface));
  }
  if (options.configure) ConfigureLink(interface, *options.configure);
  if (!IsInterfaceUp(interface)) {
    throw base::EnvironmentError("CAN interface " + interface +
                                 " is down; set it up: " + SetUpCommand(interface, options));
  }
  if (const auto link = ReadLink(interface); options.data_bit_rate_bit_s != 0 && link && !link->takes_fd) {
    throw base::EnvironmentError("the DBC has CAN FD messages, and " + interface +
                                 " is set up for classic frames only; " +
                                 SetUpForFdCommand(interface, options));
  }
}

bool Attach(int socket, const std::string& interface, const std::vector<can_filter>& filters) noexcept {
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
  if (address.can_ifindex == 0) return false;
  const auto size = static_cast<socklen_t>(filters.size() * sizeof(can_filter));
  if (::setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), size) != 0) return false;
  const void* generic = &address;
  return ::bind(socket, static_cast<const sockaddr*>(generic), sizeof address) == 0;
}

FileDescriptor OpenRawSocket() {
  FileDescriptor socket(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!socket) {
    const int error = errno;
    if (error == EAFNOSUPPORT || error == EPROTONOSUPPORT) {
      throw base::EnvironmentError(
          "this kernel has no CAN (where it has the modules: sudo modprobe -a can_raw vcan); "
          "use --can slcan:pty instead");
    }
    throw base::EnvironmentError("cannot open a CAN socket: " + ErrorText(error));
  }
  constexpr int kOn = 1;
  constexpr int kOff = 0;
  SetOption(socket.Get(), SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, kOff, "CAN_RAW_RECV_OWN_MSGS");
  SetOption(socket.Get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, CAN_ERR_MASK, "CAN_RAW_ERR_FILTER");
  SetOption(socket.Get(), SOL_CAN_RAW, CAN_RAW_FD_FRAMES, kOn, "CAN_RAW_FD_FRAMES");
  SetOption(socket.Get(), SOL_SOCKET, SO_RXQ_OVFL, kOn, "SO_RXQ_OVFL");
  SetOption(socket.Get(), SOL_SOCKET, SO_TIMESTAMPNS, kOn, "SO_TIMESTAMPNS");
  return socket;
}

}  // namespace servohil::can
