#pragma once
/// TOML values as text.

#include <toml++/toml.h>

#include <string>

namespace servohil::configuration {

/// For messages: as it was written, in one line; the shortest digits that are the same number.
std::string Shown(const toml::node& node);

/// As TOML reads it: the same value, on one line or several.
std::string AsToml(const toml::node& node);

}  // namespace servohil::configuration
