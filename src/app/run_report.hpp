#pragma once
/// What `servohil run` tells its user: ready line, status line, summary, verdict.

#include <string>

#include "servohil/app/emulator.hpp"
#include "servohil/can/network.hpp"

namespace servohil::app {

/// The status line, once a second on a terminal.
std::string StatusLine(const Telemetry& telemetry, double ticks_per_s, const can::BusStatistics& bus);

/// The summary at the end, several lines.
std::string Summary(const Emulator& emulator, const can::Network& network, const LoopSettings& loop);

/// "VALID" or "INVALID: reasons".
struct Verdict {
  bool valid;
  std::string text;
};
Verdict JudgeRun(const Telemetry& final);

}  // namespace servohil::app
