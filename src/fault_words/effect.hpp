#pragma once
/// Whether a fault that is asked for would change anything: faults that are accepted and have no effect are
/// not passed over in silence.

#include <string>

#include "fault_words/injection_words.hpp"

namespace servohil::fault_words {

/// One line; empty: it has an effect.
std::string WhyNoEffect(const fault::Spec& spec, const fault::Injection& injection,
                        const FaultContext& context);

}  // namespace servohil::fault_words
