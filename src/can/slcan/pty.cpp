#include "can/slcan/pty.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "base/error.hpp"

namespace servohil::can {
namespace {

constexpr int kFlags = O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC;

}  // namespace

Pty::Pty() : master_(::posix_openpt(kFlags)) {
  std::array<char, 128> path{};
  if (!master_ || ::grantpt(master_.Get()) != 0 || ::unlockpt(master_.Get()) != 0 ||
      ::ptsname_r(master_.Get(), path.data(), path.size()) != 0) {
    throw base::EnvironmentError("cannot make a pseudo-terminal (is /dev/pts mounted?): " +
                                 std::generic_category().message(errno));
  }
  slave_path_ = path.data();
  // Opened and closed once, it says "nobody there" (EIO) from the start.
  if (!OpenSlave()) throw base::EnvironmentError("cannot open the pseudo-terminal " + slave_path_);
  SetRaw();
}

FileDescriptor Pty::OpenSlave() const noexcept {
  return FileDescriptor(::ioctl(master_.Get(), TIOCGPTPEER, kFlags));
}

void Pty::SetRaw() const noexcept {
  termios settings{};
  if (::tcgetattr(master_.Get(), &settings) != 0) return;  // the master's attributes are the slave's
  ::cfmakeraw(&settings);
  ::tcsetattr(master_.Get(), TCSANOW, &settings);
}

std::ptrdiff_t Pty::Read(std::span<char> buffer) const noexcept {
  ssize_t size = 0;
  do {
    size = ::read(master_.Get(), buffer.data(), buffer.size());
  } while (size < 0 && errno == EINTR);
  if (size >= 0) return size;
  return errno == EAGAIN ? 0 : -1;
}

std::size_t Pty::Write(std::string_view text) const noexcept {
  ssize_t size = 0;
  do {
    size = ::write(master_.Get(), text.data(), text.size());
  } while (size < 0 && errno == EINTR);
  return size > 0 ? static_cast<std::size_t>(size) : 0;
}

std::string Pty::TakeBackUnread() const {
  const FileDescriptor slave = OpenSlave();
  if (!slave) return {};
  // A read that finds the line buffer empty first waits until the kernel has moved what it can from the queue
  // behind it: nothing to read means nothing there.
  constexpr int kMaxReads = 64;  // of 4095 bytes; a terminal holds at most 17 of them
  std::string unread;
  std::array<char, 4096> buffer{};
  for (int i = 0; i < kMaxReads; ++i) {
    const ssize_t size = ::read(slave.Get(), buffer.data(), buffer.size());
    if (size <= 0) break;
    unread.append(buffer.data(), static_cast<std::size_t>(size));
  }
  ::tcflush(slave.Get(), TCIFLUSH);  // where a client has turned on line editing, reading returns little
  return unread;
}

std::optional<int> Pty::Unread() const noexcept {
  pollfd master{master_.Get(), 0, 0};
  if (::poll(&master, 1, 0) > 0 && (master.revents & POLLHUP) != 0) return std::nullopt;
  const FileDescriptor slave = OpenSlave();
  if (!slave) return std::nullopt;
  pollfd entry{slave.Get(), POLLIN, 0};
  if (::poll(&entry, 1, 0) <= 0) return 0;  // looks behind the line buffer, too
  int bytes = 0;
  return ::ioctl(slave.Get(), FIONREAD, &bytes) == 0 && bytes > 0 ? bytes : 1;
}

void Pty::DiscardUnread() const noexcept {
  const FileDescriptor slave = OpenSlave();
  if (slave) ::tcflush(slave.Get(), TCIFLUSH);
}

}  // namespace servohil::can
