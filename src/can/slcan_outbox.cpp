#include "slcan_outbox.hpp"

#include <algorithm>

#include "slcan_codec.hpp"

namespace servohil::can::slcan {
namespace {

// A terminal holds at most 64 KiB in buffers and 4 KiB in its line buffer (Linux 6.1 and 6.18; 20 KB were
// measured with lines of 21 bytes, for which the buffers' own overhead counts).
constexpr std::size_t kRemembered = 73'728;  // bytes, 72 KiB

bool EndsLine(char c) {
  return c == '\r' || c == '\a';
}

bool BeginsLine(std::string_view text, std::size_t at) {
  return at == 0 || EndsLine(text[at - 1]);
}

/// The line that is begun at `at`: what of it lies before, what after (with its end). Both empty at a beginning.
struct BegunLine {
  std::string read;
  std::string rest;
};

BegunLine BegunAt(std::string_view text, std::size_t at) {
  if (BeginsLine(text, at)) return {};
  const std::size_t before = text.find_last_of("\r\a", at - 1);
  const std::size_t begin = before == std::string_view::npos ? 0 : before + 1;
  const std::size_t last = text.find_first_of("\r\a", at);
  const std::size_t end = last == std::string_view::npos ? text.size() : last + 1;
  return {std::string(text.substr(begin, at - begin)), std::string(text.substr(at, end - at))};
}

/// Frames whose line begins at or after `at`.
std::uint64_t CountFrames(std::string_view text, std::size_t at) {
  std::uint64_t frames = 0;
  for (; at < text.size(); ++at) {
    if (BeginsLine(text, at) && IsFrameLetter(text[at])) ++frames;
  }
  return frames;
}

}  // namespace

Outbox::Outbox(const Pty& pty) : pty_(pty) {
  history_.reserve(2 * kRemembered + kLongestLine + 1);
}

void Outbox::Remember(std::string_view text) {
  history_ += text;
  if (history_.size() <= 2 * kRemembered) return;
  const std::size_t end = history_.find('\r', history_.size() - kRemembered);
  history_.erase(0, end == std::string::npos ? end : end + 1);
}

std::size_t Outbox::FindUnread(std::string_view taken_back) const {
  // A piece of a line could be in many places.
  const bool has_line_end = taken_back.find_first_of("\r\a") != std::string_view::npos;
  return has_line_end ? history_.find(taken_back) : std::string::npos;
}

Outbox::Outcome Outbox::Write(std::string_view line) {
  const std::size_t before = history_.size();
  const std::size_t fitted = pty_.Write(line);
  Remember(line);
  if (fitted == line.size()) return {true, 0};

  // Full. If a piece of this line fitted in, it is taken back with the others.
  const std::size_t at = FindUnread(pty_.TakeBackUnread());
  Outcome outcome;
  BegunLine begun{"?", "\r"};  // where the client is, is not known: ends whatever line it has begun
  if (at != std::string::npos) {
    begun = BegunAt(history_, at);
    outcome.lost_frames = CountFrames(std::string_view(history_).substr(0, before), at);
  }
  const std::string text = begun.rest + std::string(line);
  outcome.written = pty_.Write(text) == text.size();
  history_ = begun.read + text;
  return outcome;
}

std::uint64_t Outbox::TakeBack() {
  const std::size_t at = FindUnread(pty_.TakeBackUnread());
  if (at == std::string::npos) return 0;  // it has read everything
  const BegunLine begun = BegunAt(history_, at);
  const std::uint64_t lost = CountFrames(history_, at);
  pty_.Write(begun.rest);
  history_ = begun.read + begun.rest;
  return lost;
}

void Outbox::Reset() {
  pty_.DiscardUnread();
  history_.clear();
}

}  // namespace servohil::can::slcan
