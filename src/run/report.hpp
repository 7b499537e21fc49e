#pragma once
/// What `servohil run` tells its user: status line, summary, verdict.

#include <string>
#include <vector>

#include "can/network.hpp"
#include "emulator/emulator.hpp"

namespace servohil::run {

/// Once, where it waits for the governor. @param start  where it begins
std::string ReadyLine(const can::Network& network, const simulation::RunState& start,
                      const emulator::EmulatorOptions& options);

/// The status line, once a second on a terminal.
std::string StatusLine(const simulation::RunState& run_state, double ticks_per_s,
                       const emulator::Emulator& emulator, const can::BusStatistics& bus);

/// What the simulation came to: ticks, state, state hash; one line each.
std::string SimulationSummary(const simulation::RunState& end);

/// The summary of a run on a bus, several lines, without the verdict.
std::string Summary(const emulator::Emulator& emulator, const can::Network& network,
                    const emulator::EmulatorOptions& options);

/// One of the worst overruns of a run, and the tick at which it was latest.
struct WorstOverrun {
  std::uint64_t tick = 0;
  rt::LateWake late;
};
/// In the order of time. After the run.
std::vector<WorstOverrun> WorstOverruns(const emulator::Emulator& emulator, int wake_ticks);

/// Whether a verdict about a governor may rest on this run.
struct Verdict {
  std::vector<std::string> reasons;  ///< why not; none: it may
  bool Valid() const { return reasons.empty(); }
  std::string Text() const;  ///< "VALID" or "INVALID: reasons"
};
/// @param lost_frames  that the receiver never saw; they only matter where frames let time pass (lockstep)
Verdict JudgeRun(const simulation::RunState& end, std::uint64_t lost_frames,
                 const std::optional<can::BusModelStatistics>& modelled = std::nullopt);

/// "woke late"
const char* NameOf(rt::LateCause cause);

}  // namespace servohil::run
