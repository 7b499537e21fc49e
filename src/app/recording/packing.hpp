#pragma once

#include <cstdint>

namespace servohil::app {

/// How a column's chunks are stored. All have a checksum (Fletcher-32).
enum class Packing : std::uint8_t { kDeflated, kAsIs };

}  // namespace servohil::app
