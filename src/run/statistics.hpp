#pragma once
/// The statistics of a run as JSON: `servohil run --stats FILE`.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "can/network.hpp"
#include "emulator/emulator.hpp"
#include "run/report.hpp"

namespace servohil::run {

/// While it runs, or at its end (`finished`: with verdict and the worst late wake-ups).
nlohmann::ordered_json StatisticsToJson(const emulator::Emulator& emulator, const simulation::RunState& now,
                                        const can::Network& network, const emulator::EmulatorOptions& options,
                                        bool finished);

/// While it runs, and once more at the end (`finished`: with verdict and the worst late wake-ups). Whole or
/// not at all: written beside and renamed. @throws EnvironmentError
void WriteStatistics(const std::filesystem::path& file, const emulator::Emulator& emulator,
                     const simulation::RunState& now, const can::Network& network,
                     const emulator::EmulatorOptions& options, bool finished);

}  // namespace servohil::run
