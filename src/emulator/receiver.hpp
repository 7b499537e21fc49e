#pragma once
/// Frames in: what each is, counted; what the commands say goes to the simulation.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "can/error_frame.hpp"
#include "can/frame.hpp"
#include "emulator/command_validator.hpp"
#include "emulator/delayed.hpp"
#include "emulator/simulation_task.hpp"
#include "recording/recorder.hpp"
#include "rt/mailbox.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::emulator {

/// Frames received; totals since the start.
struct ReceiveCounters {
  std::atomic<std::uint64_t> foreign{0};  ///< of other identifiers
  std::atomic<std::uint64_t> faulted{0};  ///< lost by an injected fault: not among the others
  std::atomic<std::uint64_t> conflicting{
      0};                                ///< another node's, with an identifier that the emulator publishes
  std::atomic<std::uint64_t> errors{0};  ///< error frames
  std::array<std::atomic<std::uint64_t>, simulation::kFrameVerdicts>
      of{};                            ///< with the command's, by verdict
  std::atomic<std::uint64_t> lost{0};  ///< missing between those, as their counter tells

  std::uint64_t Of(simulation::FrameVerdict verdict) const noexcept {
    return of[static_cast<std::size_t>(verdict)];
  }
};

/// Whose time a frame's age and its distance from the one before are measured in.
enum class FrameClock : std::uint8_t { kReal, kSimulated };

/// One thread.
class Receiver {
 public:
  /// All must outlive it; `recorder` may be null. @param buses  how many there are. @param clock  kSimulated:
  /// of the ticks so far, no frame ages; Take() is then called by the thread that runs the ticks
  Receiver(const signal_map::SignalMap& signal_map, const CommandValidator& validator, SimulationTask& task,
           recording::Recorder* recorder, std::size_t buses, FrameClock clock)
      : signal_map_(signal_map),
        validator_(validator),
        task_(task),
        recorder_(recorder),
        clock_(clock),
        inputs_(buses) {}

  /// Faults may lose it or let it wait. What a frame without P1 says of enable and trip goes with the next
  /// command. @return whether it is of the command's message, whatever becomes of it
  bool Take(const can::Frame& frame) noexcept;
  /// Evaluates what has waited long enough.
  void TakeDelayed() noexcept;
  /// Something waits.
  bool HasDelayed() const noexcept { return !delayed_.Empty(); }
  /// Valid commands so far.
  std::uint64_t ValidCommands() const noexcept { return validator_.Newest().counts.Valid(); }

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
  FrameTime TimeOf(const can::Frame& frame) const noexcept;
  void TakeCommand(const can::Frame& frame, const std::optional<signal_map::Demand>& demand,
                   signal_map::CommandRejection why) noexcept;
  void TakeCondition(const can::Frame& frame, const std::optional<signal_map::Demand>& demand,
                     signal_map::CommandRejection why) noexcept;
  void TakeError(const can::Frame& frame) noexcept;
  bool IsOurs(const can::Frame& frame) const noexcept;

  static constexpr std::size_t kMaxDelayed = 1'024;

  const signal_map::SignalMap& signal_map_;
  CommandValidator validator_;
  SimulationTask& task_;
  recording::Recorder* recorder_;
  FrameClock clock_;
  std::deque<Input> inputs_;  ///< of each bus
  fault::Schedule faults_;
  std::uint64_t arrivals_ = 0;
  Delayed<can::Frame> delayed_{kMaxDelayed};
  ReceiveCounters counters_;
};

}  // namespace servohil::emulator
