#pragma once
/// The buses of the configuration: whether each is there, up, at the right bit rate, and without errors.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "bench/findings.hpp"
#include "bench/system_files.hpp"
#include "configuration/configuration.hpp"

namespace servohil::bench {

/// What only the controller knows.
struct Controller {
  std::optional<std::uint32_t> bit_rate_bit_s;
  bool physical = false;  ///< all but vcan and vxcan: a run needs can.allow_physical
  std::string state;      ///< as can::DescribeInterface() says it: "up, 500000 bit/s, error-active"
};
using AskController = std::function<Controller(const std::string& interface)>;

/// Asks the kernel of this machine.
Controller AskKernel(const std::string& interface);

/// For each bus in can.buses what state it is in, and whether a run may use it.
Findings CheckBuses(const SystemFiles& files, const configuration::CanSettings& can,
                    const AskController& ask);

}  // namespace servohil::bench
