#pragma once
/// A pseudo-terminal of which we hold the master side.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "can/file_descriptor.hpp"

namespace servohil::can {

/// Linux behaviour that this builds on: while nobody has the slave open, reading the master fails with EIO
/// and polling it returns POLLHUP without end; what is written then waits for the next who opens the slave.
class Pty {
 public:
  /// @throws EnvironmentError
  Pty();

  const std::string& SlavePath() const noexcept { return slave_path_; }
  int Fd() const noexcept { return master_.Get(); }

  /// No echo, no line editing, no translation, whatever a client has left behind.
  void SetRaw() const noexcept;
  /// Never blocks. @return bytes read, 0 when there are none now, -1 when nobody has the slave open
  std::ptrdiff_t Read(std::span<char> buffer) const noexcept;
  /// Never blocks. @return bytes that fitted in
  std::size_t Write(std::string_view text) const noexcept;

  /// Takes back what the slave side has not read; empty when there is nothing. Not to be used while it reads:
  /// what it reads meanwhile is missing in the middle.
  std::string TakeBackUnread() const;
  /// What the slave side has not read of what has arrived there: bytes; 0 when it has read everything;
  /// nothing when nobody has it open. More may wait behind it, so that a slow reader leaves the number as it
  /// is for a while.
  std::optional<int> Unread() const noexcept;
  /// Discards what the slave side has not read.
  void DiscardUnread() const noexcept;

 private:
  FileDescriptor OpenSlave() const noexcept;

  FileDescriptor master_;
  std::string slave_path_;
};

}  // namespace servohil::can
