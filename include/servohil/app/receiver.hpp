#pragma once
/// Frames in: what each is, counted; commands go to the simulation.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "servohil/app/contract.hpp"
#include "servohil/app/delayed.hpp"
#include "servohil/app/recording/recorder.hpp"
#include "servohil/app/simulation_task.hpp"
#include "servohil/can/error_frame.hpp"
#include "servohil/can/frame.hpp"
#include "servohil/rt/mailbox.hpp"

namespace servohil::app {

/// Frames received, and why some did not count; totals since the start.
struct ReceiveCounters {
  std::atomic<std::uint64_t> commands{0};
  std::atomic<std::uint64_t> foreign{0};
  std::atomic<std::uint64_t> malformed{0};
  std::atomic<std::uint64_t> out_of_range{0};
  std::atomic<std::uint64_t> faulted{0};  ///< lost by an injected fault: not among the others
  std::atomic<std::uint64_t> conflicting{
      0};                                ///< another node's, with an identifier that the emulator publishes
  std::atomic<std::uint64_t> errors{0};  ///< error frames
};

/// One thread.
class Receiver {
 public:
  /// All must outlive it; `recorder` may be null. @param buses  how many there are
  Receiver(const Contract& contract, SimulationTask& task, Recorder* recorder, std::size_t buses)
      : contract_(contract), task_(task), recorder_(recorder), inputs_(buses) {}

  /// Faults may lose it or let it wait. What a frame without P1 says of enable and trip goes with the next
  /// command. @return whether it was a valid command, whatever becomes of it
  bool Take(const can::Frame& frame) noexcept;
  /// Evaluates what has waited long enough.
  void TakeDelayed() noexcept;
  /// Something waits.
  bool HasDelayed() const noexcept { return !delayed_.Empty(); }

  /// Any thread.
  const ReceiveCounters& Counters() const noexcept { return counters_; }
  /// Any one thread: what the error frames of this bus have told, when they have told more.
  bool TakeErrors(std::size_t bus, can::ErrorTotals& errors) noexcept {
    return inputs_[bus].newest.Take(errors);
  }
  /// Any thread: frames of this bus that another node sent with an identifier that the emulator publishes.
  std::uint64_t Conflicts(std::size_t bus) const noexcept { return inputs_[bus].conflicts; }

 private:
  struct Input {
    can::ErrorTotals errors;
    rt::Mailbox<can::ErrorTotals> newest;
    std::atomic<std::uint64_t> conflicts{0};
  };

  void Evaluate(const can::Frame& frame) noexcept;
  void TakeCommand(const can::Frame& frame) noexcept;
  void TakeError(const can::Frame& frame) noexcept;
  bool IsOurs(const can::Frame& frame) const noexcept;

  static constexpr std::size_t kMostDelayed = 1'024;

  const Contract& contract_;
  SimulationTask& task_;
  Recorder* recorder_;
  std::deque<Input> inputs_;  ///< of each bus
  Command command_;           ///< the newest of what each message says
  fault::Schedule faults_;
  std::uint64_t arrivals_ = 0;
  Delayed<can::Frame> delayed_{kMostDelayed};
  ReceiveCounters counters_;
};

}  // namespace servohil::app
