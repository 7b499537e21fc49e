#pragma once
/// [[can.publish]], from TOML and back.

#include <toml++/toml.h>

#include <functional>
#include <string>
#include <vector>

#include "configuration/signal_map_settings.hpp"

namespace servohil::configuration {

/// Where a part of the text stands: "FILE:LINE", or "--set KEY=VALUE".
using PlaceOfNode = std::function<std::string(const toml::node&)>;

/// @throws UsageError with place, key, value and what would be right
std::vector<MessageSettings> ReadPublished(const toml::node& node, const PlaceOfNode& place);
/// @throws UsageError unless it is a list of pairs of numbers; `key` is its name
Scale ReadScale(const toml::node& node, const std::string& key, const PlaceOfNode& place);

}  // namespace servohil::configuration
