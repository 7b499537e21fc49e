#pragma once
/// Where the checkout's files are.

#include <string>

namespace servohil::testing {

/// "/path/of/the/checkout/FILE"
std::string SourceFile(const std::string& file);

/// "/path/of/the/checkout/config/FILE"
inline std::string ConfigFile(const std::string& file) {
  return SourceFile("config/" + file);
}

}  // namespace servohil::testing
