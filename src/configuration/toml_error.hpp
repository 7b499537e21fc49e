#pragma once
/// What toml++ says of a text that is no TOML, in words that lead on.

#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace servohil::configuration {

/// "bench.toml:10: p1 = GOV.P1: could not determine value type: a text stands in quotes".
/// @param text  what stands in `file`
std::string DescribeTomlError(const toml::parse_error& error, std::string_view text, const std::string& file);

}  // namespace servohil::configuration
