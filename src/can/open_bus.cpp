#include "base/error.hpp"
#include "can/bus.hpp"
#include "can/slcan/slcan_adapter.hpp"
#include "can/slcan/slcan_serial.hpp"
#include "can/socketcan/interface_state.hpp"
#include "can/socketcan/socketcan.hpp"

namespace servohil::can {
namespace {

/// What follows `prefix` in `text`; nothing when it does not begin so.
std::optional<std::string> After(const std::string& prefix, const std::string& text) {
  if (text.rfind(prefix, 0) != 0) return std::nullopt;
  return text.substr(prefix.size());
}

std::string Suggestion(const std::string& url) {
  const bool looks_so = url.rfind("can", 0) == 0 || url.rfind("vcan", 0) == 0;
  if (IsCanInterface(url) || looks_so) return "; did you mean socketcan:" + url + "?";
  if (url == "pty" || url == "slcan") return "; did you mean slcan:pty?";
  if (url.rfind("/dev/", 0) == 0) return "; did you mean slcan:" + url + "?";
  return {};
}

[[noreturn]] void ThrowUnknown(const std::string& url) {
  throw base::UsageError("unknown bus '" + url +
                         "': expected socketcan:IFACE, slcan:pty[:LINK] or slcan:/dev/DEVICE" +
                         Suggestion(url));
}

}  // namespace

std::unique_ptr<Bus> OpenBus(const std::string& url, const BusOptions& options) {
  if (const auto interface = After("socketcan:", url); interface && !interface->empty()) {
    return std::make_unique<SocketCan>(*interface, options);
  }
  if (url == "slcan:pty") return std::make_unique<SlcanAdapter>("");
  if (const auto link = After("slcan:pty:", url); link && !link->empty()) {
    return std::make_unique<SlcanAdapter>(*link);
  }
  if (const auto device = After("slcan:", url); device && device->rfind('/', 0) == 0) {
    return std::make_unique<SlcanSerial>(*device, options);
  }
  ThrowUnknown(url);
}

void CheckUrl(const std::string& url) {
  const auto interface = After("socketcan:", url);
  const auto link = After("slcan:pty:", url);
  const auto device = After("slcan:", url);
  const bool known = (interface && !interface->empty()) || (link && !link->empty()) || url == "slcan:pty" ||
                     url == "auto" || (device && device->rfind('/', 0) == 0);
  if (!known) ThrowUnknown(url);
}

std::string AutomaticUrl(std::span<const std::string> interfaces, bool allow_physical) {
  for (const std::string& interface : interfaces) {
    if (IsCanInterface(interface) && (allow_physical || IsVirtualInterface(interface)))
      return "socketcan:" + interface;
  }
  return "slcan:pty";
}

std::string PhysicalRefusal(const std::string& url) {
  return url +
         " is a physical bus, where a real machine may be: --set can.allow_physical=true if servohil may "
         "send there";
}

}  // namespace servohil::can
