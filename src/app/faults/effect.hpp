#pragma once
/// Whether a fault that is asked for would change anything: faults that are accepted and have no effect are
/// not passed over in silence.

#include <string>

#include "injection_words.hpp"

namespace servohil::app {

/// One line; empty: it has an effect.
std::string WhyNoEffect(const fault::Spec& spec, const fault::Injection& injection,
                        const FaultContext& context);

}  // namespace servohil::app
