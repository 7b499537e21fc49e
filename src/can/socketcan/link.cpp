#include "can/socketcan/link.hpp"

#include <linux/can.h>
#include <linux/can/netlink.h>
#include <net/if.h>
#include <net/if_arp.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <system_error>

#include "base/error.hpp"
#include "can/socketcan/netlink.hpp"

namespace servohil::can {
namespace {

template <typename T>
T ValueOf(const nlattr* attribute) noexcept {
  T value{};
  std::memcpy(&value, mnl_attr_get_payload(attribute),
              std::min<std::size_t>(sizeof value, mnl_attr_get_payload_len(attribute)));
  return value;
}

int ParseKind(const nlattr* attribute, void* data) {
  if (mnl_attr_get_type(attribute) == IFLA_INFO_KIND)
    static_cast<Link*>(data)->kind = mnl_attr_get_str(attribute);
  return MNL_CB_OK;
}

int ParseAttribute(const nlattr* attribute, void* data) {
  if (mnl_attr_get_type(attribute) == IFLA_LINKINFO) mnl_attr_parse_nested(attribute, ParseKind, data);
  if (mnl_attr_get_type(attribute) == IFLA_MTU)
    static_cast<Link*>(data)->takes_fd = ValueOf<std::uint32_t>(attribute) >= CANFD_MTU;
  if (mnl_attr_get_type(attribute) == IFLA_STATS64) {
    const auto statistics = ValueOf<rtnl_link_stats64>(attribute);
    static_cast<Link*>(data)->rx_packets = statistics.rx_packets;
    static_cast<Link*>(data)->tx_packets = statistics.tx_packets;
  }
  return MNL_CB_OK;
}

int ParseLink(const nlmsghdr* message, void* data) {
  if (message->nlmsg_type != RTM_NEWLINK) return MNL_CB_OK;
  const auto* const header = static_cast<const ifinfomsg*>(mnl_nlmsg_get_payload(message));
  Link& link = *static_cast<Link*>(data);
  link.index = header->ifi_index;
  link.is_can = header->ifi_type == ARPHRD_CAN;
  link.up = (header->ifi_flags & IFF_UP) != 0;
  mnl_attr_parse(message, sizeof(ifinfomsg), ParseAttribute, data);
  return MNL_CB_STOP;
}

/// Changes a setting of interfaces of kind "can".
template <typename T>
int SetController(const std::string& name, std::uint16_t attribute, const T& value, std::string& reason) {
  LinkRequest request(RTM_NEWLINK, NLM_F_ACK, name);
  nlattr* const info = mnl_attr_nest_start(request.Message(), IFLA_LINKINFO);
  mnl_attr_put_strz(request.Message(), IFLA_INFO_KIND, "can");
  nlattr* const data = mnl_attr_nest_start(request.Message(), IFLA_INFO_DATA);
  mnl_attr_put(request.Message(), attribute, sizeof value, &value);
  mnl_attr_nest_end(request.Message(), data);
  mnl_attr_nest_end(request.Message(), info);
  return request.Exchange(nullptr, nullptr, reason);
}

// Each asks libsocketcan. What is refused is asked once more, by libmnl, for the kernel's number and text.

int SetUp(const std::string& name, bool up, std::string& reason) {
  if (can::SetUp(name, up)) return 0;
  LinkRequest request(RTM_NEWLINK, NLM_F_ACK, name);
  request.SetUp(up);
  return request.Exchange(nullptr, nullptr, reason);
}

int SetBitTiming(const std::string& name, const LinkSettings& settings, std::string& reason) {
  if (can::SetBitTiming(name, settings.bit_rate_bit_s, settings.sample_point)) return 0;
  can_bittiming timing{};
  timing.bitrate = settings.bit_rate_bit_s;
  timing.sample_point = static_cast<std::uint32_t>(std::lround(settings.sample_point * kSamplePointUnit));
  return SetController(name, IFLA_CAN_BITTIMING, timing, reason);
}

int SetRestartMs(const std::string& name, std::uint32_t restart_ms, std::string& reason) {
  if (can::SetRestartMs(name, restart_ms)) return 0;
  return SetController(name, IFLA_CAN_RESTART_MS, restart_ms, reason);
}

int Restart(const std::string& name, std::string& reason) {
  if (can::Restart(name)) return 0;
  const std::uint32_t now = 1;
  return SetController(name, IFLA_CAN_RESTART, now, reason);
}

int SetQueueLength(const std::string& name, std::uint32_t frames, std::string& reason) {
  LinkRequest request(RTM_NEWLINK, NLM_F_ACK, name);
  mnl_attr_put_u32(request.Message(), IFLA_TXQLEN, frames);
  return request.Exchange(nullptr, nullptr, reason);
}

bool IsMissingPermission(int error) noexcept {
  return error == EPERM || error == EACCES;
}

std::string Fixed(double value) {
  const std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 4);
}

std::string ClockText(const Controller& controller) {
  return controller.clock_hz == 0 ? "" : " (its clock: " + std::to_string(controller.clock_hz) + " Hz)";
}

RestartResult ResultOf(int error) noexcept {
  if (error == 0) return RestartResult::kDone;
  return IsMissingPermission(error) ? RestartResult::kNotPermitted : RestartResult::kRefused;
}

/// Beyond its range, of which the kernel only says EINVAL or EDOM.
bool IsOutOfRange(int error) noexcept {
  return error == EINVAL || error == EDOM || error == ERANGE;
}

[[noreturn]] void FailToReach(const std::string& name, const Controller& controller,
                              const LinkSettings& settings) {
  std::string keys = "can.bit_rate_bit_s = " + std::to_string(settings.bit_rate_bit_s);
  if (settings.sample_point > 0.0) keys += " with can.sample_point = " + Fixed(settings.sample_point);
  throw base::EnvironmentError(keys + ": the controller of " + name + " cannot do that" +
                               ClockText(controller) + "; its range: ip -details link show " + name);
}

[[noreturn]] void FailToConfigure(const std::string& name, const LinkSettings& settings, int error,
                                  const std::string& reason) {
  if (IsMissingPermission(error)) {
    throw base::EnvironmentError("can.configure: no permission to set up " + name +
                                 " (CAP_NET_ADMIN); this does it: " + ConfigureCommands(name, settings));
  }
  throw base::EnvironmentError("can.configure: the kernel does not set up " + name + ": " +
                               (reason.empty() ? std::generic_category().message(error) : reason));
}

}  // namespace

std::optional<Link> ReadLink(const std::string& name) {
  if (name.empty() || name.size() >= IFNAMSIZ) return std::nullopt;
  Link link;
  std::string reason;
  LinkRequest request(RTM_GETLINK, 0, name);
  if (request.Exchange(ParseLink, &link, reason) != 0 || link.index == 0) return std::nullopt;
  if (link.kind == "can") link.controller = ReadController(name);
  return link;
}

std::string ConfigureCommands(const std::string& name, const LinkSettings& settings) {
  std::string sample_point;
  if (settings.sample_point > 0.0) sample_point = " sample-point " + Fixed(settings.sample_point);
  const std::string set = "sudo ip link set " + name;
  return set + " down; " + set + " type can bitrate " + std::to_string(settings.bit_rate_bit_s) +
         sample_point + " restart-ms " + std::to_string(settings.restart_ms) + "; " + set + " txqueuelen " +
         std::to_string(settings.queue_length) + " up";
}

std::string BitTimingMismatch(const std::string& name, const Controller& told, const LinkSettings& wanted) {
  const std::string nearest = ": the nearest that the controller of " + name + " can do";
  const double rate = wanted.bit_rate_bit_s;
  if (told.bit_rate_bit_s != 0 && std::abs(told.bit_rate_bit_s - rate) > kMaxBitRateError * rate) {
    return "can.bit_rate_bit_s = " + std::to_string(wanted.bit_rate_bit_s) + nearest + " is " +
           std::to_string(told.bit_rate_bit_s) + ClockText(told);
  }
  constexpr double kRounding = 1e-6;
  if (told.sample_point > 0.0 && wanted.sample_point > 0.0 &&
      std::abs(told.sample_point - wanted.sample_point) > kMaxSamplePointError + kRounding) {
    return "can.sample_point = " + Fixed(wanted.sample_point) + nearest + " at " +
           std::to_string(told.bit_rate_bit_s) + " bit/s is " + Fixed(told.sample_point) + ClockText(told) +
           "; set that if it suits the other nodes";
  }
  return {};
}

void ConfigureLink(const std::string& name, const LinkSettings& settings) {
  const std::optional<Link> link = ReadLink(name);
  std::string reason;
  const auto require = [&](int error) {
    if (error != 0) FailToConfigure(name, settings, error, reason);
  };
  if (link && link->controller) {
    require(SetUp(name, false, reason));
    const int timing = SetBitTiming(name, settings, reason);
    if (IsOutOfRange(timing)) FailToReach(name, *link->controller, settings);
    require(timing);
    const std::optional<Link> now = ReadLink(name);
    if (now && now->controller) {
      const std::string mismatch = BitTimingMismatch(name, *now->controller, settings);
      if (!mismatch.empty()) throw base::EnvironmentError(mismatch);
    }
    const int restart = SetRestartMs(name, settings.restart_ms, reason);
    if (restart != EOPNOTSUPP) require(restart);
    require(SetQueueLength(name, settings.queue_length, reason));
  }
  require(SetUp(name, true, reason));
}

RestartResult RestartLink(const std::string& name) {
  std::string reason;
  const int error = Restart(name, reason);
  return error == EOPNOTSUPP ? ResetLink(name) : ResultOf(error);
}

RestartResult ResetLink(const std::string& name) {
  std::string reason;
  const int error = SetUp(name, false, reason);
  return ResultOf(error == 0 ? SetUp(name, true, reason) : error);
}

}  // namespace servohil::can
