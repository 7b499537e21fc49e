#pragma once
/// `servohil run --check-config`: what a run would refuse, all at once, before it begins.

#include <string>
#include <vector>

#include "configuration/source.hpp"

namespace servohil::run {

/// Reads configuration, load table and DBC, and checks all that a run checks without opening a bus. Each
/// mistake is one line on standard error. @param buses  those of --can; empty: of the configuration
/// @return exit status: kExitOk or kExitUsage
int CheckConfiguration(const configuration::ConfigurationOptions& options,
                       const std::vector<std::string>& buses);

}  // namespace servohil::run
