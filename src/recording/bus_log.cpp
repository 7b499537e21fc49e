#include "recording/bus_log.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "base/error.hpp"
#include "base/formatted.hpp"

namespace servohil::recording {

std::string CandumpLine(std::int64_t time_ns, const std::string& bus, const can::Frame& frame) {
  constexpr std::int64_t kNsPerUs = 1'000;
  constexpr std::int64_t kUsPerS = 1'000'000;
  const std::int64_t time_us = time_ns / kNsPerUs;
  std::string line = base::Formatted("(%010lld.%06lld) ", static_cast<long long>(time_us / kUsPerS),
                                     static_cast<long long>(time_us % kUsPerS));
  line += bus;
  constexpr std::uint32_t kErrorFlag = 0x2000'0000;
  line += frame.error ? base::Formatted(" %08X#", frame.id | kErrorFlag)
                      : base::Formatted(frame.extended ? " %08X#" : " %03X#", frame.id);
  if (frame.remote) {
    line += 'R';
    if (frame.size > 0) line += std::to_string(frame.size);
  } else {
    if (frame.fd) line += frame.bit_rate_switch ? "#1" : "#0";
    constexpr const char* kDigits = "0123456789ABCDEF";
    for (std::size_t i = 0; i < frame.size; ++i) {
      line += kDigits[frame.data[i] >> 4U];
      line += kDigits[frame.data[i] & 15U];
    }
  }
  line += '\n';
  return line;
}

BusLog::BusLog(const std::filesystem::path& file)
    : file_(file.string()), fd_(::open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)) {
  if (fd_ < 0) {
    throw base::EnvironmentError(file_ + ": cannot be made: " + std::generic_category().message(errno));
  }
}

BusLog::~BusLog() {
  ::close(fd_);
}

void BusLog::Add(std::int64_t time_ns, const std::string& bus, const can::Frame& frame) {
  pending_ += CandumpLine(time_ns, bus, frame);
}

void BusLog::Flush() {
  std::string_view rest = pending_;
  int error = 0;
  while (!rest.empty() && error == 0) {
    const ssize_t written = ::write(fd_, rest.data(), rest.size());
    if (written >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (error == 0) {
    size_bytes_ += static_cast<std::int64_t>(pending_.size());
  } else {
    static_cast<void>(::ftruncate(fd_, size_bytes_));
  }
  pending_.clear();
  if (error != 0)
    throw base::EnvironmentError(file_ + " cannot be written: " + std::generic_category().message(error));
}

}  // namespace servohil::recording
