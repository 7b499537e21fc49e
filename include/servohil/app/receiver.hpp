#pragma once
/// Frames in: what each is, counted; what the commands say goes to the simulation.

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "servohil/app/command_guard.hpp"
#include "servohil/app/contract.hpp"
#include "servohil/app/recording/recorder.hpp"
#include "servohil/app/simulation_task.hpp"
#include "servohil/can/frame.hpp"

namespace servohil::app {

/// Frames received; totals since the start.
struct ReceiveCounters {
  std::atomic<std::uint64_t> foreign{0};                        ///< of other identifiers
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
           FrameClock clock) noexcept
      : contract_(contract), guard_(guard), task_(task), recorder_(recorder), clock_(clock) {}

  /// What became of it as a command; empty: it has another identifier.
  std::optional<FrameVerdict> Take(const can::Frame& frame) noexcept;

  /// Any thread.
  const ReceiveCounters& Counters() const noexcept { return counters_; }

 private:
  FrameTime TimeOf(const can::Frame& frame) const noexcept;

  const Contract& contract_;
  CommandGuard guard_;
  SimulationTask& task_;
  Recorder* recorder_;
  FrameClock clock_;
  ReceiveCounters counters_;
};

}  // namespace servohil::app
