#pragma once
/// Frames in: what each is, counted; commands go to the simulation.

#include <atomic>
#include <cstdint>

#include "servohil/app/contract.hpp"
#include "servohil/app/recording/recorder.hpp"
#include "servohil/app/simulation_task.hpp"
#include "servohil/can/frame.hpp"

namespace servohil::app {

/// Frames received, and why some did not count; totals since the start.
struct ReceiveCounters {
  std::atomic<std::uint64_t> commands{0};
  std::atomic<std::uint64_t> foreign{0};
  std::atomic<std::uint64_t> malformed{0};
  std::atomic<std::uint64_t> out_of_range{0};
};

/// One thread.
class Receiver {
 public:
  /// All must outlive it; `recorder` may be null.
  Receiver(const Contract& contract, SimulationTask& task, Recorder* recorder) noexcept
      : contract_(contract), task_(task), recorder_(recorder) {}

  /// What a frame without P1 says of enable and trip goes with the next command.
  /// @return whether it was a valid command
  bool Take(const can::Frame& frame) noexcept;

  /// Any thread.
  const ReceiveCounters& Counters() const noexcept { return counters_; }

 private:
  const Contract& contract_;
  SimulationTask& task_;
  Recorder* recorder_;
  Command command_;  ///< the newest of what each message says
  ReceiveCounters counters_;
};

}  // namespace servohil::app
