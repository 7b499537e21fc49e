#pragma once
/// `servohil run --clock fast`: no bus, commands from the script, as fast as it goes.

#include <optional>

#include "emulator/simulation_task.hpp"
#include "run/run_options.hpp"
#include "run/stop_signals.hpp"

namespace servohil::run {

/// @param from  where it begins; nothing: at rest. @return exit status. @throws UsageError
int RunFast(const RunOptions& options, const RunSetup& setup, const std::optional<emulator::Snapshot>& from,
            const StopSignals& signals);

}  // namespace servohil::run
