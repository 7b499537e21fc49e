#pragma once
/// FAULTS.md, from the catalogue.

#include <string>

namespace servohil::fault {
struct Spec;
}

namespace servohil::fault_words {

/// "servohil fault inject air_entrainment fraction=0.02 ramp_s=0.5 for_s=3"
std::string ExampleLine(const fault::Spec& spec);

std::string FaultDocument();

}  // namespace servohil::fault_words
