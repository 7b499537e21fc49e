#pragma once
/// What every fuzzer here shares. Each defines FuzzOne(); a finding is an abort, a sanitizer's report, memory
/// or time without end.

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "servohil/error.hpp"

/// @return 0; -1: this input is not worth keeping
int FuzzOne(std::string_view input);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return FuzzOne({reinterpret_cast<const char*>(data), size});
}

inline void Require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "not so: %s\n", what);
  std::abort();
}

/// Nothing but the error that a user is told, in one line, may come out of it.
template <typename Act>
void RequireOneLine(Act&& act) {
  try {
    act();
  } catch (const servohil::UsageError& error) {
    const std::string_view text = error.what();
    Require(!text.empty() && text.find('\n') == std::string_view::npos, "an error is one line");
  }
}
