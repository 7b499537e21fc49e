#include "can/slcan/slcan_codec.hpp"

#include <algorithm>

#include "can/data_length.hpp"

namespace servohil::can::slcan {
namespace {

constexpr std::size_t kStandardDigits = 3;
constexpr std::size_t kExtendedDigits = 8;
constexpr std::size_t kTimestampDigits = 4;
constexpr std::uint32_t kLargestStandardId = 0x7FF;
constexpr std::uint32_t kLargestExtendedId = 0x1FFF'FFFF;
constexpr std::uint32_t kLargestTimestamp = 59'999;  // ms
constexpr std::uint8_t kLargestClassicCode = 8;

void AppendHex(LineText& line, std::uint32_t value, std::size_t digits) noexcept {
  for (std::size_t i = digits; i-- > 0;) {
    line.text[line.size++] = "0123456789ABCDEF"[(value >> (4 * i)) & 0xFU];
  }
}

char Letter(const Frame& frame) noexcept {
  if (frame.fd && frame.bit_rate_switch) return frame.extended ? 'B' : 'b';
  if (frame.fd) return frame.extended ? 'D' : 'd';
  if (frame.remote) return frame.extended ? 'R' : 'r';
  return frame.extended ? 'T' : 't';
}

/// Hexadecimal digits off the front of `text`; nothing when there are too few or another character.
std::optional<std::uint32_t> TakeHex(std::string_view& text, std::size_t digits) noexcept {
  if (text.size() < digits) return std::nullopt;
  std::uint32_t value = 0;
  for (const char c : text.substr(0, digits)) {
    std::uint32_t digit = 0;
    if (c >= '0' && c <= '9') {
      digit = static_cast<std::uint32_t>(c - '0');
    } else if (c >= 'A' && c <= 'F') {
      digit = static_cast<std::uint32_t>(c - 'A') + 10;
    } else if (c >= 'a' && c <= 'f') {
      digit = static_cast<std::uint32_t>(c - 'a') + 10;
    } else {
      return std::nullopt;
    }
    value = value << 4U | digit;
  }
  text.remove_prefix(digits);
  return value;
}

}  // namespace

bool IsFrameLetter(char letter) noexcept {
  return letter != '\0' && std::string_view("tTrRdDbB").find(letter) != std::string_view::npos;
}

LineText FormatFrame(const Frame& frame, std::optional<std::uint16_t> timestamp_ms) noexcept {
  LineText line;
  line.text[line.size++] = Letter(frame);
  if (frame.extended) {
    AppendHex(line, frame.id & kLargestExtendedId, kExtendedDigits);
  } else {
    AppendHex(line, frame.id & kLargestStandardId, kStandardDigits);
  }
  const std::uint8_t code =
      std::min(CodeOfSize(frame.size), frame.fd ? std::uint8_t{15} : kLargestClassicCode);
  AppendHex(line, code, 1);
  if (frame.fd || !frame.remote) {
    for (std::size_t i = 0; i < kSizeOfCode[code]; ++i)
      AppendHex(line, i < frame.size ? frame.data[i] : 0U, 2);
  }
  if (timestamp_ms) AppendHex(line, *timestamp_ms, kTimestampDigits);
  line.text[line.size++] = '\r';
  return line;
}

std::optional<Frame> ParseFrame(std::string_view line, Timestamp timestamp) noexcept {
  if (line.empty() || !IsFrameLetter(line.front())) return std::nullopt;
  const char letter = line.front();
  line.remove_prefix(1);
  Frame frame;
  frame.extended = letter == 'T' || letter == 'R' || letter == 'D' || letter == 'B';
  frame.remote = letter == 'r' || letter == 'R';
  frame.bit_rate_switch = letter == 'b' || letter == 'B';
  frame.fd = frame.bit_rate_switch || letter == 'd' || letter == 'D';
  const auto id = TakeHex(line, frame.extended ? kExtendedDigits : kStandardDigits);
  const auto code = TakeHex(line, 1);
  if (!id || *id > (frame.extended ? kLargestExtendedId : kLargestStandardId)) return std::nullopt;
  if (!code || (!frame.fd && *code > kLargestClassicCode)) return std::nullopt;
  frame.id = *id;
  frame.size = kSizeOfCode[*code];
  for (std::size_t i = 0; !frame.remote && i < frame.size; ++i) {
    const auto byte = TakeHex(line, 2);
    if (!byte) return std::nullopt;
    frame.data[i] = static_cast<std::uint8_t>(*byte);
  }
  if (line.empty()) return frame;
  const auto stamp = TakeHex(line, kTimestampDigits);
  if (timestamp == Timestamp::kRefused || !stamp || *stamp > kLargestTimestamp || !line.empty()) {
    return std::nullopt;
  }
  return frame;
}

}  // namespace servohil::can::slcan
