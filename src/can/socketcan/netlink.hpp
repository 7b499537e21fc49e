#pragma once
/// One exchange with the kernel's routing netlink, by libmnl: for what libsocketcan lacks (link.hpp says
/// what).

#include <libmnl/libmnl.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

#include <array>
#include <cstdint>
#include <string>

namespace servohil::can {

class LinkRequest {
 public:
  /// @param type, flags  RTM_GETLINK, RTM_NEWLINK; NLM_F_ACK where nothing else is answered
  LinkRequest(std::uint16_t type, std::uint16_t flags, const std::string& interface) noexcept;
  LinkRequest(const LinkRequest&) = delete;  // what it builds stands inside it
  LinkRequest& operator=(const LinkRequest&) = delete;

  nlmsghdr* Message() noexcept { return message_; }
  /// Takes the interface up or down.
  void SetUp(bool up) noexcept;

  /// Sends it and waits for the answer. @return 0, or the errno that the kernel answered; `reason` is then
  /// its own text, where it gave one
  /// @param parse  called with each message of the answer; null: none is expected
  int Exchange(mnl_cb_t parse, void* data, std::string& reason);

 private:
  std::array<char, 1024> buffer_{};
  nlmsghdr* message_;
  ifinfomsg* header_;
};

}  // namespace servohil::can
