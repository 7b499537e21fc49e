#include "run/candump.hpp"

#include <charconv>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "base/readable.hpp"

namespace servohil::run {
namespace {

constexpr std::size_t kStandardDigits = 3;
constexpr std::size_t kExtendedDigits = 8;
constexpr std::int64_t kMaxSeconds = std::numeric_limits<std::int64_t>::max() / base::kNsPerS - 1;
constexpr std::uint32_t kStandardMask = 0x7FF;
constexpr std::uint32_t kErrorFlag = 0x2000'0000;
constexpr std::uint32_t kIdMask = 0x1FFF'FFFF;

template <typename Number>
std::optional<Number> Parse(std::string_view text, int base) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// "(1436509052.249713)": seconds, a point, and digits of a fraction.
std::optional<std::int64_t> ParseTime(std::string_view text) {
  if (text.size() < 3 || text.front() != '(' || text.back() != ')') return std::nullopt;
  text = text.substr(1, text.size() - 2);
  const std::size_t point = text.find('.');
  const auto seconds = Parse<std::int64_t>(text.substr(0, point), 10);
  if (!seconds || *seconds < 0 || *seconds > kMaxSeconds) return std::nullopt;
  if (point == std::string_view::npos) return *seconds * base::kNsPerS;
  std::string digits(text.substr(point + 1, 9));
  digits.resize(9, '0');
  const auto fraction = Parse<std::int64_t>(digits, 10);
  if (!fraction || *fraction < 0) return std::nullopt;
  return *seconds * base::kNsPerS + *fraction;
}

bool ParseData(std::string_view text, can::Frame& frame) {
  const std::size_t most = frame.fd ? 64 : 8;
  if (text.size() % 2 != 0 || text.size() / 2 > most) return false;
  frame.size = static_cast<std::uint8_t>(text.size() / 2);
  for (std::size_t i = 0; i < frame.size; ++i) {
    const auto byte = Parse<std::uint8_t>(text.substr(2 * i, 2), 16);
    if (!byte) return false;
    frame.data[i] = *byte;
  }
  return true;
}

/// "044#2A36", "1ABCDEF0#R", "123##1AABB".
std::optional<can::Frame> ParseFrame(std::string_view text, bool& is_error_frame) {
  const std::size_t hash = text.find('#');
  if (hash != kStandardDigits && hash != kExtendedDigits) return std::nullopt;
  const auto id = Parse<std::uint32_t>(text.substr(0, hash), 16);
  if (!id || (hash == kStandardDigits && *id > kStandardMask)) return std::nullopt;
  can::Frame frame;
  frame.extended = hash == kExtendedDigits;
  frame.id = *id & kIdMask;
  is_error_frame = frame.extended && (*id & kErrorFlag) != 0;
  std::string_view data = text.substr(hash + 1);
  if (data.substr(0, 1) == "R") {
    frame.remote = true;
    const auto size = data.size() == 1 ? 0 : Parse<std::uint8_t>(data.substr(1), 16);
    if (!size || *size > 8) return std::nullopt;
    frame.size = *size;
    return frame;
  }
  if (data.substr(0, 1) == "#") {
    const auto flags = data.size() < 2 ? std::nullopt : Parse<std::uint8_t>(data.substr(1, 1), 16);
    if (!flags) return std::nullopt;
    frame.fd = true;
    frame.bit_rate_switch = (*flags & 1U) != 0;
    data.remove_prefix(2);
  }
  // candump may add "_8" (raw length code) behind the data of a classical frame.
  if (!frame.fd) data = data.substr(0, data.find('_'));
  return ParseData(data, frame) ? std::optional(frame) : std::nullopt;
}

}  // namespace

std::vector<LoggedFrame> ReadCandump(const std::filesystem::path& file) {
  base::RequireReadable(file);
  std::ifstream in(file);
  std::vector<LoggedFrame> frames;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream words(line);
    std::string time;
    std::string bus;
    std::string text;
    if (!(words >> time)) continue;
    words >> bus >> text;
    bool is_error_frame = false;
    const auto time_ns = ParseTime(time);
    auto frame = ParseFrame(text, is_error_frame);
    if (!time_ns || !frame) {
      throw base::UsageError(
          file.string() + ":" + std::to_string(number) + ": \"" + line.substr(0, 60) +
          "\" is no line of a candump log, such as (1436509052.249713) vcan0 044#2A366C2BBA");
    }
    if (is_error_frame) continue;
    frame->receive_time_ns = *time_ns;
    frames.push_back({*frame, bus, number});
  }
  return frames;
}

}  // namespace servohil::run
