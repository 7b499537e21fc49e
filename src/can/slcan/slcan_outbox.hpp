#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "can/slcan/pty.hpp"

namespace servohil::can::slcan {

/// Lines on their way to the client of a pseudo-terminal, whole or not at all. What a client does not read
/// fills the terminal. Then new lines are refused, as a serial adapter does. Once nothing has fitted in for
/// kStalled, the client has stopped reading: what it has not read is taken back, so that it finds fresh lines
/// when it goes on; the rest of a line that it is in the middle of stays. Where it is follows from how much
/// was taken back, and from a copy of what was written.
class Outbox {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  /// The kernel makes room 4 KB at a time: a client that reads at all, at 8 kB/s or more, does so twice a
  /// second.
  static constexpr std::chrono::milliseconds kStalled{500};

  /// Keeps a reference to `pty`.
  explicit Outbox(const Pty& pty);

  struct Outcome {
    bool written = false;           ///< or will be, as soon as there is room for the rest of it
    std::uint64_t lost_frames = 0;  ///< older ones, written and taken back
  };
  /// `line` with its CR (or BEL). Never blocks.
  Outcome Write(std::string_view line, TimePoint now);
  /// Waits until the client has read everything, while it reads at all: kDrainStalled without a byte read,
  /// kDrainLongest in all. Then it may look for more for kDrainLinger. Takes back what it has not read. @return frames lost; 0 where the client has
  /// left
  std::uint64_t Drain();
  /// Takes back what the client has not read, as above. @return frames lost
  std::uint64_t TakeBack();
  /// The client is gone: nothing of all this is for the next one.
  void Reset();

 private:
  bool TryWrite(std::string_view line);
  void Remember(std::string_view line);
  /// Where in `history_` the client will read on, when this text is what it has not read; nothing when
  /// unknown.
  std::optional<std::size_t> Find(std::string_view unread) const;
  std::uint64_t DropFrom(std::size_t at);

  const Pty& pty_;
  std::string history_;  ///< what was written last, from the beginning of a line
  std::string pending_;  ///< rest of the last line: it did not fit in
  std::optional<TimePoint> full_since_;
};

}  // namespace servohil::can::slcan
