#include "rt/cpu_latency.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace servohil::rt {

CpuLatencyHold::CpuLatencyHold(const char* device) : fd_(open(device, O_RDWR | O_CLOEXEC)) {
  constexpr std::int32_t kMicroseconds = 0;
  if (fd_ >= 0 && write(fd_, &kMicroseconds, sizeof kMicroseconds) == sizeof kMicroseconds) return;
  const std::string name = device;
  missing_.push_back("CPUs may enter deep idle states, " + name + " (" +
                     std::generic_category().message(errno) + "): sudo chmod o+rw " + name);
}

CpuLatencyHold::~CpuLatencyHold() {
  if (fd_ >= 0) close(fd_);
}

}  // namespace servohil::rt
