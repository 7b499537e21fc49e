#pragma once
/// `servohil run` on a bus: in real time, or in lockstep with the governor.

#include <optional>

#include "run_options.hpp"
#include "servohil/app/simulation_task.hpp"
#include "stop_signals.hpp"

namespace servohil::app {

/// @param from  where it begins; nothing: at rest. @return exit status. @throws UsageError, EnvironmentError
int RunOnBus(const RunOptions& options, const RunSetup& setup, const std::optional<Snapshot>& from,
             const StopSignals& signals);

}  // namespace servohil::app
