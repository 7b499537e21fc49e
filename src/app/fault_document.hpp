#pragma once
/// FAULTS.md, from the catalogue.

#include <string>

namespace servohil::app {

std::string FaultDocument();

}  // namespace servohil::app
