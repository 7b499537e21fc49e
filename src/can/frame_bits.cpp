#include "can/frame_bits.hpp"

#include <algorithm>
#include <cstddef>

#include "can/data_length.hpp"

namespace servohil::can {

int WorstCaseFrameBits(int size_bytes, bool extended) noexcept {
  const int stuffable = (extended ? 54 : 34) + 8 * size_bytes;
  return stuffable + 13 + (stuffable - 1) / 4;
}

FrameBits WorstCaseFdFrameBits(int size_bytes, bool extended, bool bit_rate_switch) noexcept {
  const int padded = kSizeOfCode[CodeOfSize(static_cast<std::size_t>(std::max(size_bytes, 0)))];
  const int arbitration = extended ? 36 : 17;
  const int end = 13;
  const int content = 5 + 8 * padded;  // ESI, DLC, data
  const int check = padded <= 16 ? 4 + 17 + 6 : 4 + 21 + 7;
  const int stuff = (arbitration + content - 1) / 4;
  const int slow_stuff = (arbitration - 1) / 4;
  const FrameBits bits{arbitration + slow_stuff + end, content + (stuff - slow_stuff) + check};
  return bit_rate_switch ? bits : FrameBits{bits.nominal + bits.data, 0};
}

FrameBits WorstCaseBits(const Message& message) noexcept {
  if (message.fd) return WorstCaseFdFrameBits(message.size_bytes, message.extended, message.bit_rate_switch);
  return {WorstCaseFrameBits(message.size_bytes, message.extended), 0};
}

FrameBits WorstCaseBits(const Frame& frame) noexcept {
  if (frame.fd) return WorstCaseFdFrameBits(frame.size, frame.extended, frame.bit_rate_switch);
  return {WorstCaseFrameBits(frame.remote ? 0 : frame.size, frame.extended), 0};
}

std::uint32_t ArbitrationRank(const Frame& frame) noexcept {
  // 11 bits of the id; RTR, or SRR which is recessive; IDE; the other 18 bits; RTR.
  const std::uint32_t remote = frame.remote ? 1U : 0U;
  if (!frame.extended) return frame.id << 21U | remote << 20U;
  constexpr std::uint32_t kSrrAndIde = 3U << 19U;
  constexpr std::uint32_t kLow18 = 0x3'FFFF;
  return (frame.id >> 18U) << 21U | kSrrAndIde | (frame.id & kLow18) << 1U | remote;
}

}  // namespace servohil::can
