#include "can/socketcan/netlink.hpp"

#include <linux/netlink.h>
#include <net/if.h>

#include <cerrno>
#include <memory>

namespace servohil::can {
namespace {

constexpr unsigned kSequence = 1;  // one exchange a socket

struct Close {
  void operator()(mnl_socket* socket) const noexcept { mnl_socket_close(socket); }
};
using Socket = std::unique_ptr<mnl_socket, Close>;

Socket Open() noexcept {
  Socket socket(mnl_socket_open2(NETLINK_ROUTE, SOCK_CLOEXEC));
  if (!socket || mnl_socket_bind(socket.get(), 0, MNL_SOCKET_AUTOPID) != 0) return nullptr;
  int on = 1;
  mnl_socket_setsockopt(socket.get(), NETLINK_EXT_ACK, &on, sizeof on);
  mnl_socket_setsockopt(socket.get(), NETLINK_CAP_ACK, &on, sizeof on);
  return socket;
}

/// The text that the kernel adds to a refusal.
std::string ReasonIn(const nlmsghdr* answer) {
  std::string reason;
  if (answer->nlmsg_type != NLMSG_ERROR || (answer->nlmsg_flags & NLM_F_ACK_TLVS) == 0) return reason;
  mnl_attr_parse(
      answer, sizeof(nlmsgerr),
      [](const nlattr* attribute, void* text) {
        if (mnl_attr_get_type(attribute) == NLMSGERR_ATTR_MSG)
          *static_cast<std::string*>(text) = mnl_attr_get_str(attribute);
        return MNL_CB_OK;
      },
      &reason);
  return reason;
}

}  // namespace

LinkRequest::LinkRequest(std::uint16_t type, std::uint16_t flags, const std::string& interface) noexcept
    : message_(mnl_nlmsg_put_header(buffer_.data())) {
  message_->nlmsg_type = type;
  message_->nlmsg_flags = static_cast<std::uint16_t>(NLM_F_REQUEST | flags);
  message_->nlmsg_seq = kSequence;
  header_ = static_cast<ifinfomsg*>(mnl_nlmsg_put_extra_header(message_, sizeof(ifinfomsg)));
  header_->ifi_family = AF_UNSPEC;
  mnl_attr_put_strz(message_, IFLA_IFNAME, interface.substr(0, IFNAMSIZ - 1).c_str());
}

void LinkRequest::SetUp(bool up) noexcept {
  header_->ifi_change = IFF_UP;
  header_->ifi_flags = up ? static_cast<unsigned>(IFF_UP) : 0U;
}

int LinkRequest::Exchange(mnl_cb_t parse, void* data, std::string& reason) {
  const Socket socket = Open();
  if (!socket) return errno;
  if (mnl_socket_sendto(socket.get(), message_, message_->nlmsg_len) < 0) return errno;
  alignas(nlmsghdr) std::array<char, 16'384> answer{};
  const ssize_t size = mnl_socket_recvfrom(socket.get(), answer.data(), answer.size());
  if (size < 0) return errno;
  const int result = mnl_cb_run(answer.data(), static_cast<std::size_t>(size), kSequence,
                                mnl_socket_get_portid(socket.get()), parse, data);
  if (result >= MNL_CB_STOP) return 0;
  const int error = errno;
  const void* const first = answer.data();
  reason = ReasonIn(static_cast<const nlmsghdr*>(first));
  return error;
}

}  // namespace servohil::can
