#pragma once
/// Data length codes of ISO 11898-1: sizes 0 to 8 are their own code, CAN FD goes on in seven steps.

#include <array>
#include <cstddef>
#include <cstdint>

namespace servohil::can {

inline constexpr std::array<std::uint8_t, 16> kSizeOfCode{0, 1,  2,  3,  4,  5,  6,  7,
                                                          8, 12, 16, 20, 24, 32, 48, 64};

/// Smallest code whose size holds `size` bytes; more than 64 count as 64.
constexpr std::uint8_t CodeOfSize(std::size_t size) noexcept {
  std::uint8_t code = 0;
  while (code < 15 && kSizeOfCode[code] < size) ++code;
  return code;
}

}  // namespace servohil::can
