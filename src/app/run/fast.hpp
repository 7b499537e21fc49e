#pragma once
/// `servohil run --clock fast`: no bus, commands from the script, as fast as it goes.

#include <optional>

#include "run_options.hpp"
#include "servohil/app/simulation_task.hpp"
#include "stop_signals.hpp"

namespace servohil::app {

/// @param from  where it begins; nothing: at rest. @return exit status. @throws UsageError
int RunFast(const RunOptions& options, const RunSetup& setup, const std::optional<Snapshot>& from,
            const StopSignals& signals);

}  // namespace servohil::app
