#pragma once
/// What a serial CAN adapter answers to its client's lines. Pure: no terminal, no clock.
///
/// | line        | meaning                          | answer                                                |
/// |-------------|----------------------------------|-------------------------------------------------------|
/// | S0 ... S8   | bit rate                         | CR; BEL while open                                    |
/// | sxxyy       | bit timing registers             | CR; BEL while open                                    |
/// | Yn          | CAN FD data bit rate (CANable 2) | CR; BEL while open                                    |
/// | O, L        | open, listen only                | CR; BEL while open                                    |
/// | C           | close                            | CR; BEL while closed                                  |
/// | t T r R ... | send a frame                     | z CR (11-bit id), Z CR (29-bit id); BEL unless opened |
/// | V, N        | version, serial number           | V0101 CR, NHIL1 CR                                    |
/// | F           | status flags, read and cleared   | Fxx CR; BEL while closed                              |
/// | Z0, Z1      | time stamps off, on              | CR; BEL while open                                    |
/// | M..., m...  | acceptance filter: no effect     | CR                                                    |
/// | empty       | (clients clear the line so)      | CR                                                    |
/// | other       |                                  | BEL                                                   |
///
/// A virtual bus has no bit rate: it is accepted and forgotten.

#include <cstdint>
#include <optional>
#include <string_view>

#include "can/frame.hpp"

namespace servohil::can::slcan {

/// Bit of the answer to F: frames for the client were lost because it did not read.
inline constexpr std::uint8_t kFlagDataOverrun = 0x08;

struct Answer {
  std::string_view text;       ///< to write back; a literal, or valid until the next Handle()
  std::optional<Frame> frame;  ///< that the client puts on the bus
  bool malformed = false;      ///< neither a command nor a frame
};

class Session {
 public:
  /// `line` without its CR.
  Answer Handle(std::string_view line) noexcept;
  /// The client is gone: channel closed, time stamps off.
  void Reset() noexcept { *this = Session(); }

  bool IsOpen() const noexcept { return open_; }
  bool IsListenOnly() const noexcept { return listen_only_; }
  bool HasTimestamps() const noexcept { return timestamps_; }
  /// Frames were lost: F will say so once.
  void SetOverrun() noexcept { flags_ = kFlagDataOverrun; }

 private:
  Answer HandleFrame(std::string_view line) const noexcept;
  Answer Open(bool listen_only) noexcept;
  Answer Close() noexcept;
  Answer ReadFlags() noexcept;
  Answer SetTimestamps(char digit) noexcept;
  Answer AcceptWhileClosed() const noexcept;

  bool open_ = false;
  bool listen_only_ = false;
  bool timestamps_ = false;
  std::uint8_t flags_ = 0;
};

}  // namespace servohil::can::slcan
