#include "can/slcan/slcan_session.hpp"

#include <algorithm>

#include "can/slcan/slcan_codec.hpp"

namespace servohil::can::slcan {
namespace {

constexpr std::string_view kOk = "\r";
constexpr std::string_view kRefused = "\a";

bool AreHexDigits(std::string_view text) noexcept {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'F') || (c >= 'a' && c <= 'f');
  });
}

Answer Say(std::string_view text) noexcept {
  return {text, std::nullopt, false};
}
Answer Malformed() noexcept {
  return {kRefused, std::nullopt, true};
}

}  // namespace

Answer Session::HandleFrame(std::string_view line) const noexcept {
  const std::optional<Frame> frame = ParseFrame(line, Timestamp::kRefused);
  if (!frame) return Malformed();
  if (!open_ || listen_only_) return Say(kRefused);
  return {frame->extended ? "Z\r" : "z\r", frame, false};
}

Answer Session::Open(bool listen_only) noexcept {
  if (open_) return Say(kRefused);
  open_ = true;
  listen_only_ = listen_only;
  return Say(kOk);
}

Answer Session::Close() noexcept {
  if (!open_) return Say(kRefused);
  open_ = false;
  return Say(kOk);
}

Answer Session::ReadFlags() noexcept {
  if (!open_) return Say(kRefused);
  const bool overrun = flags_ != 0;
  flags_ = 0;
  static_assert(kFlagDataOverrun == 0x08);
  return Say(overrun ? "F08\r" : "F00\r");
}

Answer Session::SetTimestamps(char digit) noexcept {
  if (open_) return Say(kRefused);
  timestamps_ = digit == '1';
  return Say(kOk);
}

Answer Session::AcceptWhileClosed() const noexcept {
  return Say(open_ ? kRefused : kOk);
}

Answer Session::Handle(std::string_view line) noexcept {
  if (line.empty()) return Say(kOk);
  if (IsFrameLetter(line.front())) return HandleFrame(line);
  const std::string_view rest = line.substr(1);
  const bool one_digit = rest.size() == 1 && rest[0] >= '0' && rest[0] <= '9';
  switch (line.front()) {
    case 'S':
      return one_digit && rest[0] <= '8' ? AcceptWhileClosed() : Malformed();
    case 's':
      return rest.size() == 4 && AreHexDigits(rest) ? AcceptWhileClosed() : Malformed();
    case 'Y':
      return one_digit ? AcceptWhileClosed() : Malformed();
    case 'Z':
      return rest == "0" || rest == "1" ? SetTimestamps(rest[0]) : Malformed();
    case 'M':
    case 'm':
      return !rest.empty() && AreHexDigits(rest) ? Say(kOk) : Malformed();
    default:
      break;
  }
  if (!rest.empty()) return Malformed();
  switch (line.front()) {
    case 'O':
      return Open(false);
    case 'L':
      return Open(true);
    case 'C':
      return Close();
    case 'F':
      return ReadFlags();
    case 'V':
      return Say("V0101\r");
    case 'N':
      return Say("NHIL1\r");
    default:
      return Malformed();
  }
}

}  // namespace servohil::can::slcan
