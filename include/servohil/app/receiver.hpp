#pragma once
/// Frames in: what each is, counted; commands go to the simulation.

#include <atomic>
#include <cstdint>

#include "servohil/app/contract.hpp"
#include "servohil/app/delayed.hpp"
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
  std::atomic<std::uint64_t> faulted{0};  ///< lost by an injected fault: not among the others
};

/// One thread.
class Receiver {
 public:
  /// All must outlive it; `recorder` may be null.
  Receiver(const Contract& contract, SimulationTask& task, Recorder* recorder)
      : contract_(contract), task_(task), recorder_(recorder) {}

  /// Faults may lose it or let it wait. @return whether it was a valid command, whatever becomes of it
  bool Take(const can::Frame& frame) noexcept;
  /// Evaluates what has waited long enough.
  void TakeDelayed() noexcept;
  /// Something waits.
  bool HasDelayed() const noexcept { return !delayed_.Empty(); }

  /// Any thread.
  const ReceiveCounters& Counters() const noexcept { return counters_; }

 private:
  void Evaluate(const can::Frame& frame) noexcept;

  static constexpr std::size_t kMostDelayed = 1'024;

  const Contract& contract_;
  SimulationTask& task_;
  Recorder* recorder_;
  fault::Schedule faults_;
  std::uint64_t arrivals_ = 0;
  Delayed<can::Frame> delayed_{kMostDelayed};
  ReceiveCounters counters_;
};

}  // namespace servohil::app
