#pragma once
/// Refuses at start what the integration would not resolve: model::SweepEnvelope over P1 from 0 to 300 psi.

#include <string>

#include "configuration/configuration.hpp"
#include "model/derived.hpp"

namespace servohil::configuration {

/// A warning in one line, or nothing. Physics "thesis" is only warned about: its equations have neither stops
/// nor cavitation, so that no integration makes its large motions right, and comparisons need them as they
/// are.
/// @throws UsageError, one line: where in the envelope, which rate, sub-steps, errors, and the keys to change
std::string CheckEnvelope(const Configuration& configuration, const model::Derived& derived);

}  // namespace servohil::configuration
