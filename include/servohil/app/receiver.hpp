#pragma once
/// Frames in: what each is, counted; what the commands say goes to the simulation.

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "servohil/app/command_guard.hpp"
#include "servohil/app/contract.hpp"
#include "servohil/app/delayed.hpp"
#include "servohil/app/recording/recorder.hpp"
#include "servohil/app/simulation_task.hpp"
#include "servohil/can/frame.hpp"

namespace servohil::app {

/// Frames received; totals since the start.
struct ReceiveCounters {
  std::atomic<std::uint64_t> foreign{0};  ///< of other identifiers
  std::atomic<std::uint64_t> faulted{0};  ///< lost by an injected fault: not among the others
  std::array<std::atomic<std::uint64_t>, kFrameVerdicts> of{};  ///< with the command's, by verdict
  std::atomic<std::uint64_t> lost{0};  ///< missing between those, as their counter tells

  std::uint64_t Of(FrameVerdict verdict) const noexcept { return of[static_cast<std::size_t>(verdict)]; }
};

/// Whose time a frame's age and its distance from the one before are measured in.
enum class FrameClock : std::uint8_t { kReal, kSimulated };

/// One thread.
class Receiver {
 public:
  /// All must outlive it; `recorder` may be null. @param clock  kSimulated: of the ticks so far, no frame
  /// ages; Take() is then called by the thread that runs the ticks
  Receiver(const Contract& contract, const CommandGuard& guard, SimulationTask& task, Recorder* recorder,
           FrameClock clock)
      : contract_(contract), guard_(guard), task_(task), recorder_(recorder), clock_(clock) {}

  /// Faults may lose it or let it wait. @return whether it has the command's identifier, whatever becomes of
  /// it
  bool Take(const can::Frame& frame) noexcept;
  /// Evaluates what has waited long enough.
  void TakeDelayed() noexcept;
  /// Something waits.
  bool HasDelayed() const noexcept { return !delayed_.Empty(); }
  /// Valid commands so far.
  std::uint64_t ValidCommands() const noexcept { return guard_.Newest().counts.Valid(); }

  /// Any thread.
  const ReceiveCounters& Counters() const noexcept { return counters_; }

 private:
  void Evaluate(const can::Frame& frame) noexcept;
  FrameTime TimeOf(const can::Frame& frame) const noexcept;

  static constexpr std::size_t kMostDelayed = 1'024;

  const Contract& contract_;
  CommandGuard guard_;
  SimulationTask& task_;
  Recorder* recorder_;
  FrameClock clock_;
  fault::Schedule faults_;
  std::uint64_t arrivals_ = 0;
  Delayed<can::Frame> delayed_{kMostDelayed};
  ReceiveCounters counters_;
};

}  // namespace servohil::app
