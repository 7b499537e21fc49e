#pragma once
/// Holds the CPUs off the idle states that take time to leave.

#include "rt/process.hpp"

namespace servohil::rt {

/// While it exists, every CPU is to answer within 0 µs: the kernel's PM QoS, /dev/cpu_dma_latency held open
/// at 0. The kernel takes the request back when the file is closed, so also when the process is killed.
class CpuLatencyHold {
 public:
  explicit CpuLatencyHold(const char* device = "/dev/cpu_dma_latency");
  ~CpuLatencyHold();
  CpuLatencyHold(const CpuLatencyHold&) = delete;
  CpuLatencyHold& operator=(const CpuLatencyHold&) = delete;

  /// Empty when it holds.
  const Shortcomings& Missing() const noexcept { return missing_; }

 private:
  int fd_ = -1;
  Shortcomings missing_;
};

}  // namespace servohil::rt
