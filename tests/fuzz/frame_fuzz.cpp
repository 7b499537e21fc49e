// Any frame from the bus: a command within its range, or refused with a reason.

#include <algorithm>
#include <cmath>

#include "fuzz.hpp"
#include "servohil/app/contract.hpp"

namespace {

using servohil::app::Contract;

/// Identifier (4 bytes), flags, size, data: as much of it as there is.
servohil::can::Frame FrameOf(std::string_view bytes, std::uint32_t command_id) {
  constexpr std::size_t kHead = 6;
  std::array<std::uint8_t, kHead> head{};
  std::copy_n(bytes.begin(), std::min(bytes.size(), kHead), head.begin());
  bytes.remove_prefix(std::min(bytes.size(), kHead));
  servohil::can::Frame frame;
  frame.extended = (head[4] & 1U) != 0;
  frame.remote = (head[4] & 2U) != 0;
  frame.fd = (head[4] & 4U) != 0;
  frame.bit_rate_switch = (head[4] & 8U) != 0;
  std::uint32_t id = 0;
  for (std::size_t i = 0; i < 4; ++i) id = id << 8U | head[i];
  frame.id = (head[4] & 16U) != 0 ? command_id : id & (frame.extended ? 0x1FFF'FFFFU : 0x7FFU);
  frame.size = static_cast<std::uint8_t>(head[5] % (frame.fd ? 65 : 9));
  std::copy_n(bytes.begin(), std::min<std::size_t>(bytes.size(), frame.size), frame.data.begin());
  return frame;
}

}  // namespace

int FuzzOne(std::string_view bytes) {
  static const Contract contract(servohil::app::LoadConfiguration(SERVOHIL_CONFIG_DIR "/servohil.toml", {}));
  const servohil::can::Frame frame = FrameOf(bytes, contract.CommandMessage().id);
  servohil::app::CommandRejection rejection{};
  const auto command = contract.Decode(frame, rejection);
  if (command && command->p1_psi) {
    Require(frame.id == contract.CommandMessage().id && !frame.remote,
            "only the command's own frame is a command");
    Require(*command->p1_psi >= 0.0 && *command->p1_psi <= 300.0, "P1 is within its range");
  }
  return 0;
}
