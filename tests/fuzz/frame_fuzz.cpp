// Any frame from the bus: a command within its range, or refused with a reason.

#include <algorithm>
#include <cmath>

#include "fuzz.hpp"
#include "servohil/app/contract.hpp"

namespace {

using servohil::app::Contract;

/// Identifier (4 bytes), flags, size, data: as much of it as there is.
servohil::can::Frame FrameOf(std::string_view bytes, const Contract& contract) {
  constexpr std::size_t kHead = 6;
  std::array<std::uint8_t, kHead> head{};
  std::copy_n(bytes.begin(), std::min(bytes.size(), kHead), head.begin());
  bytes.remove_prefix(std::min(bytes.size(), kHead));
  const auto incoming = contract.IncomingMessages();
  const servohil::can::Message& known = *incoming[head[3] % incoming.size()].message;
  const bool is_known = (head[4] & 16U) != 0;
  servohil::can::Frame frame;
  frame.extended = is_known ? known.extended : (head[4] & 1U) != 0;
  frame.remote = (head[4] & 2U) != 0;
  frame.fd = (head[4] & 4U) != 0;
  frame.bit_rate_switch = (head[4] & 8U) != 0;
  std::uint32_t id = 0;
  for (std::size_t i = 0; i < 4; ++i) id = id << 8U | head[i];
  frame.id = is_known ? known.id : id & (frame.extended ? 0x1FFF'FFFFU : 0x7FFU);
  frame.size = static_cast<std::uint8_t>(head[5] % (frame.fd ? 65 : 9));
  std::copy_n(bytes.begin(), std::min<std::size_t>(bytes.size(), frame.size), frame.data.begin());
  return frame;
}

void Use(const Contract& contract, std::string_view bytes) {
  const servohil::can::Frame frame = FrameOf(bytes, contract);
  servohil::app::CommandRejection rejection{};
  const auto demand = contract.Decode(frame, rejection);
  if (!demand) return;
  Require(!frame.remote, "a remote frame says nothing");
  if (!demand->p1_psi) return;
  const servohil::app::ReceivedMessage& command = contract.IncomingMessages().front();
  const servohil::can::Signal& p1 = *command.p1;
  Require(std::isfinite(*demand->p1_psi), "P1 is a number");
  Require(!(p1.minimum < p1.maximum) || (*demand->p1_psi >= command.p1_to_psi(p1.minimum) &&
                                         *demand->p1_psi <= command.p1_to_psi(p1.maximum)),
          "P1 is within the range that the DBC states");
}

}  // namespace

int FuzzOne(std::string_view bytes) {
  using servohil::app::LoadConfiguration;
  static const Contract own(LoadConfiguration(SERVOHIL_CONFIG_DIR "/servohil.toml", {}));
  static const Contract foreign(LoadConfiguration(SERVOHIL_CONFIG_DIR "/examples/foreign/servohil.toml", {}));
  Use(own, bytes);
  Use(foreign, bytes);
  return 0;
}
