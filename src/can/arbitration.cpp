#include "servohil/can/arbitration.hpp"

namespace servohil::can {

std::uint32_t ArbitrationRank(const Frame& frame) noexcept {
  // 11 bits of the id; RTR, or SRR which is recessive; IDE; the other 18 bits; RTR.
  const std::uint32_t remote = frame.remote ? 1U : 0U;
  if (!frame.extended) return frame.id << 21U | remote << 20U;
  constexpr std::uint32_t kSrrAndIde = 3U << 19U;
  constexpr std::uint32_t kLow18 = 0x3'FFFF;
  return (frame.id >> 18U) << 21U | kSrrAndIde | (frame.id & kLow18) << 1U | remote;
}

}  // namespace servohil::can
