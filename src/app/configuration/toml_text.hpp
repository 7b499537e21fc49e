#pragma once
/// TOML values as messages show them.

#include <toml++/toml.h>

#include <string>

namespace servohil::app {

/// As it was written, in one line; the shortest digits that are the same number.
std::string Shown(const toml::node& node);

}  // namespace servohil::app
