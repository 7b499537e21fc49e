#pragma once
/// The statistics of a run as JSON: `servohil run --stats FILE`.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "report.hpp"
#include "servohil/app/emulator.hpp"
#include "servohil/can/network.hpp"

namespace servohil::app {

/// While it runs, or at its end (`finished`: with verdict and the worst late wake-ups).
nlohmann::ordered_json StatisticsToJson(const Emulator& emulator, const Telemetry& now,
                                        const can::Network& network, const EmulatorOptions& options,
                                        bool finished);

/// While it runs, and once more at the end (`finished`: with verdict and the worst late wake-ups). Whole or
/// not at all: written beside and renamed. @throws EnvironmentError
void WriteStatistics(const std::filesystem::path& file, const Emulator& emulator, const Telemetry& now,
                     const can::Network& network, const EmulatorOptions& options, bool finished);

}  // namespace servohil::app
