#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "pty.hpp"

namespace servohil::can::slcan {

/// Lines on their way to the client of a pseudo-terminal: whole or not at all, and rather the newest than the
/// oldest. When the terminal is full (the client does not read), what the client has not read is taken back,
/// but for the rest of the line that it is in the middle of: then it reads what is new, and no line is cut.
/// Knows what the client has read by looking for what was taken back in a copy of what was written.
class Outbox {
 public:
  /// Keeps a reference to `pty`.
  explicit Outbox(const Pty& pty);

  struct Outcome {
    bool written = false;
    std::uint64_t lost_frames = 0;  ///< older ones, accepted before
  };
  /// `line` with its CR (or BEL). Never blocks.
  Outcome Write(std::string_view line);
  /// Takes back what the client has not read, as above. @return frames lost
  std::uint64_t TakeBack();
  /// The client is gone: nothing of all this is for the next one.
  void Reset();

 private:
  /// Where in `history_` the client will read on; npos when unknown.
  std::size_t FindUnread(std::string_view taken_back) const;
  void Remember(std::string_view text);

  const Pty& pty_;
  std::string history_;  ///< what was written last, from the beginning of a line
};

}  // namespace servohil::can::slcan
