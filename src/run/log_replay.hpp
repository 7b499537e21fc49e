#pragma once
/// A candump log as the governor on the bus: its frames meet the same receiver, limits, protection and
/// supervision as in a run, in the time that the log tells.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "emulator/receiver.hpp"
#include "emulator/simulation_task.hpp"
#include "run/candump.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::run {

/// A frame, and the tick after which it arrives.
struct FrameAfter {
  std::uint64_t ticks = 0;
  can::Frame frame;
};

/// Returns the frames of one interface: `wanted`, or (empty) the only one with messages of the governor's.
/// @throws UsageError with the list of interfaces, where it is not there, or where several have such messages
std::vector<LoggedFrame> FramesOfInterface(std::vector<LoggedFrame> frames, const std::string& wanted,
                                           const signal_map::SignalMap& signal_map,
                                           const std::filesystem::path& file);

/// Returns the frames on a time line that begins with the first. Time stamps may step back by 10 ms, as
/// frames of several sources do in a log; such a frame arrives with the one before it.
/// @throws UsageError naming the line, where time steps back further, or ahead by more than 60 s: the clock
/// was set, or nothing was logged
std::vector<FrameAfter> OnTimeLine(std::span<const LoggedFrame> frames, const std::filesystem::path& file);

/// Runs `task` until its duration is over, or `after_tick()` returns false; each frame is received before the
/// tick that feels it.
template <typename AfterTick>
void RunLog(emulator::SimulationTask& task, emulator::Receiver& receiver, std::span<const FrameAfter> frames,
            AfterTick&& after_tick) {
  std::size_t next = 0;
  for (bool goes_on = true; goes_on;) {
    for (; next < frames.size() && frames[next].ticks <= task.Now().sample.tick; ++next)
      receiver.Take(frames[next].frame);
    goes_on = task.Run(1);
    goes_on = after_tick() && goes_on;
  }
}

/// "585 commands followed; refused: 15 corrupted"
std::string DescribeReceived(const emulator::ReceiveCounters& received);

}  // namespace servohil::run
