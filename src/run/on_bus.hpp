#pragma once
/// `servohil run` on a bus: in real time, or in lockstep with the governor.

#include <optional>

#include "emulator/simulation_task.hpp"
#include "run/run_options.hpp"
#include "run/stop_signals.hpp"

namespace servohil::run {

/// @param from  where it begins; nothing: at rest. @return exit status. @throws UsageError, EnvironmentError
int RunOnBus(const RunOptions& options, const RunSetup& setup, const std::optional<emulator::Snapshot>& from,
             const StopSignals& signals);

}  // namespace servohil::run
