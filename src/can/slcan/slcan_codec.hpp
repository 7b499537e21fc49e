#pragma once
/// Frames as lines of the serial adapter protocol (LAWICEL CAN232, with the CAN FD letters of CANable 2):
///
///   t iii l dd...        data frame, 11-bit id       T iiiiiiii l dd...   29-bit id
///   r iii l              remote frame                R iiiiiiii l
///   d iii l dd...        CAN FD                      D iiiiiiii l dd...
///   b iii l dd...        CAN FD, bit rate switch     B iiiiiiii l dd...
///
/// iii, iiiiiiii: id, hexadecimal.  l: length code, one hexadecimal digit (9 to F only with FD: 12, 16, 20,
/// 24, 32, 48, 64 bytes).  dd: a data byte.  An adapter may add its time stamp: four digits, 0 to EA5F ms.
/// Pure functions; nothing allocates.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "can/frame.hpp"
#include "can/slcan/slcan_line.hpp"

namespace servohil::can::slcan {

/// A line with its CR.
struct LineText {
  std::array<char, kLongestLine + 1> text{};
  std::size_t size = 0;

  std::string_view View() const noexcept { return {text.data(), size}; }
};

/// Data are padded with zeros to the next size that a length code has.
LineText FormatFrame(const Frame& frame, std::optional<std::uint16_t> timestamp_ms) noexcept;

enum class Timestamp : std::uint8_t { kRefused, kAllowed };

/// Nothing unless the whole line (without CR) is one frame: letter, digits, range of the id, exact length.
std::optional<Frame> ParseFrame(std::string_view line, Timestamp timestamp) noexcept;

/// The letter begins a frame line; whether the rest is right, ParseFrame tells.
bool IsFrameLetter(char letter) noexcept;

}  // namespace servohil::can::slcan
