#include "servohil/can/frame_bits.hpp"

namespace servohil::can {
namespace {

constexpr int kTrailerBits = 13;  // CRC delimiter, ACK slot and delimiter, end of frame 7, interframe space 3

int FdFrameBits(int size_bytes, bool extended) noexcept {
  constexpr int kStandardHeaderBits = 22;  // SOF, id 11, RRS, IDE, FDF, res, BRS, ESI, length code 4
  constexpr int kExtendedHeaderBits = 41;  // SOF, id 29, SRR, IDE, RRS, FDF, res, BRS, ESI, length code 4
  constexpr int kLongCrcFrom = 17;         // bytes
  constexpr int kStuffCountBits = 4;
  const int stuffable = (extended ? kExtendedHeaderBits : kStandardHeaderBits) + 8 * size_bytes;
  const int check_bits = kStuffCountBits + (size_bytes < kLongCrcFrom ? 17 : 21);
  const int fixed_stuff_bits = 1 + check_bits / 4;
  return stuffable + (stuffable - 1) / 4 + check_bits + fixed_stuff_bits + kTrailerBits;
}

}  // namespace

int WorstCaseFrameBits(int size_bytes, bool extended) noexcept {
  const int stuffable = (extended ? 54 : 34) + 8 * size_bytes;
  return stuffable + kTrailerBits + (stuffable - 1) / 4;
}

int WorstCaseFrameBits(const Frame& frame) noexcept {
  if (frame.fd) return FdFrameBits(frame.size, frame.extended);
  return WorstCaseFrameBits(frame.remote ? 0 : frame.size, frame.extended);
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
