#pragma once
/// A test of the effect for each fault of the catalogue, by name.

#include <map>
#include <string>

namespace servohil::fault::testing {

using Effects = std::map<std::string, void (*)()>;

extern const Effects kModelEffects;
extern const Effects kSensorEffects;
extern const Effects kBusEffects;

}  // namespace servohil::fault::testing
