#pragma once
/// The other end of a terminal, and waiting for what comes through one: by readiness, never by sleeping.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "can/bus.hpp"
#include "can/file_descriptor.hpp"

namespace servohil::can {

/// Time that no test needs: only a failure waits so long.
inline constexpr std::chrono::seconds kPatience{20};

inline void WaitReadable(int fd, int timeout_ms = 1) {
  pollfd entry{fd, POLLIN, 0};
  ::poll(&entry, 1, timeout_ms);
}

/// A program that has opened a serial device, raw.
class Client {
 public:
  explicit Client(const std::string& path)
      : fd_(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    EXPECT_TRUE(fd_) << path;
  }

  int Fd() const { return fd_.Get(); }
  void Write(const std::string& text) const {
    EXPECT_EQ(::write(fd_.Get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  /// What is there now, at most `most` bytes.
  std::string Read(std::size_t most = 4096) const {
    std::string text(most, '\0');
    const ssize_t size = ::read(fd_.Get(), text.data(), most);
    text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return text;
  }
  /// Reads until the text ends with `end`.
  std::string ReadUntil(const std::string& end) const {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    std::string text;
    while (text.size() < end.size() || text.compare(text.size() - end.size(), end.size(), end) != 0) {
      if (std::chrono::steady_clock::now() > deadline) {
        ADD_FAILURE() << "still waiting for '" << end << "' after " << text.size() << " bytes";
        break;
      }
      text += Read(1);
      WaitReadable(fd_.Get());
    }
    return text;
  }

 private:
  FileDescriptor fd_;
};

/// Calls Receive() until `done` is true; returns what came.
inline std::vector<Frame> Pump(Bus& bus, const std::function<bool(const std::vector<Frame>&)>& done) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  std::vector<Frame> frames;
  while (!done(frames)) {
    if (std::chrono::steady_clock::now() > deadline) {
      ADD_FAILURE() << "still waiting after " << frames.size() << " frames";
      break;
    }
    if (auto frame = bus.Receive()) {
      frames.push_back(*frame);
    } else {
      WaitReadable(bus.PollFd());
    }
  }
  return frames;
}

inline std::vector<Frame> PumpFrames(Bus& bus, std::size_t count) {
  return Pump(bus, [count](const auto& frames) { return frames.size() >= count; });
}

inline void PumpUntilState(Bus& bus, const std::string& state) {
  Pump(bus, [&](const auto&) { return bus.State() == state; });
}

/// A frame that carries a counter.
inline Frame Numbered(std::uint32_t number, std::uint32_t id = 0x100) {
  Frame frame;
  frame.id = id;
  frame.size = 8;
  for (unsigned i = 0; i < 4; ++i) frame.data[i] = static_cast<std::uint8_t>(number >> (8 * i));
  return frame;
}

inline std::uint32_t NumberOf(const Frame& frame) {
  std::uint32_t number = 0;
  for (unsigned i = 0; i < 4; ++i) number |= static_cast<std::uint32_t>(frame.data[i]) << (8 * i);
  return number;
}

}  // namespace servohil::can
