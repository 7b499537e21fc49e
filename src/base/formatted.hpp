#pragma once
/// printf's number formats as a std::string; <format> is missing in g++ 12.

#include <array>
#include <cstdint>
#include <cstdio>
#include <string>

namespace servohil::base {

/// At most 511 characters; the rest is cut off. @param format for exactly these arguments
template <typename... Values>
std::string Formatted(const char* format, Values... values) {
  std::array<char, 512> text{};
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-vararg): its length is bounded, and cut is as good as any
  static_cast<void>(std::snprintf(text.data(), text.size(), format, values...));
  return text.data();
}

/// A 64-bit hash as people compare it: 16 hexadecimal digits.
inline std::string HashText(std::uint64_t hash) {
  return Formatted("%016llx", static_cast<unsigned long long>(hash));
}

}  // namespace servohil::base
