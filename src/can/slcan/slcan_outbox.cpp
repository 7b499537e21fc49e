#include "can/slcan/slcan_outbox.hpp"

#include <poll.h>

#include <algorithm>

#include "can/bus.hpp"
#include "can/slcan/slcan_codec.hpp"

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

/// The line that is begun at `at`: what of it lies before, what after (with its end). Both empty at a
/// beginning.
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

void Outbox::Remember(std::string_view line) {
  history_ += line;
  if (history_.size() <= 2 * kRemembered) return;
  const std::size_t end = history_.find('\r', history_.size() - kRemembered);
  history_.erase(0, end == std::string::npos ? end : end + 1);
}

std::optional<std::size_t> Outbox::Find(std::string_view unread) const {
  const std::string_view written(history_.data(), history_.size() - pending_.size());
  if (unread.empty() || unread.size() > written.size()) return std::nullopt;
  const std::size_t at = written.size() - unread.size();
  return written.substr(at) == unread ? std::optional(at) : std::nullopt;
}

bool Outbox::TryWrite(std::string_view line) {
  if (!pending_.empty()) pending_.erase(0, pty_.Write(pending_));
  if (!pending_.empty()) return false;
  const std::size_t fitted = pty_.Write(line);
  if (fitted == 0) return false;
  Remember(line);
  pending_ = line.substr(fitted);
  return true;
}

std::uint64_t Outbox::DropFrom(std::size_t at) {
  const BegunLine begun = BegunAt(history_, at);
  const std::uint64_t lost = CountFrames(history_, at);
  history_ = begun.read + begun.rest;
  pending_ = begun.rest;
  return lost;
}

Outbox::Outcome Outbox::Write(std::string_view line, TimePoint now) {
  if (TryWrite(line)) {
    full_since_.reset();
    return {true, 0};
  }
  if (!full_since_) full_since_ = now;
  if (now - *full_since_ < kStalled) return {false, 0};
  full_since_.reset();
  const std::uint64_t lost = TakeBack();
  return {TryWrite(line), lost};
}

std::uint64_t Outbox::Drain() {
  using Clock = std::chrono::steady_clock;
  const TimePoint begin = Clock::now();
  TimePoint moved = begin;
  std::size_t rest_before = 0;
  std::optional<TimePoint> all_read;
  for (std::optional<int> before;
       Clock::now() - moved < kDrainStalled && Clock::now() - begin < kDrainLongest;) {
    if (!pending_.empty()) pending_.erase(0, pty_.Write(pending_));
    const std::optional<int> unread = pty_.Unread();
    if (!unread) return 0;  // the client has left
    if (*unread == 0 && pending_.empty()) {
      all_read = all_read.value_or(Clock::now());
      if (Clock::now() - *all_read >= kDrainLinger) return 0;
    }
    if (unread != before || pending_.size() != rest_before) moved = Clock::now();
    before = unread;
    rest_before = pending_.size();
    ::poll(nullptr, 0, 1);
  }
  return TakeBack();
}

std::uint64_t Outbox::TakeBack() {
  const std::string unread = pty_.TakeBackUnread();
  if (const std::optional<std::size_t> at = Find(unread)) return DropFrom(*at);
  if (!unread.empty() || !pending_.empty()) {  // ends whatever line the client has begun; "?" stands for that
    history_ = {'?', '\r'};
    pending_ = '\r';
  }
  return 0;
}

void Outbox::Reset() {
  pty_.DiscardUnread();
  history_.clear();
  pending_.clear();
  full_since_.reset();
}

}  // namespace servohil::can::slcan
