#pragma once
/// What every fuzzer here shares. Each defines FuzzOne(); a finding is an abort, a sanitizer's report, memory
/// or time without end.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "base/error.hpp"

/// @return 0; -1: this input is not worth keeping
int FuzzOne(std::string_view input);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return FuzzOne({reinterpret_cast<const char*>(data), size});
}

/// Most of AddressSanitizer's time goes into remembering what was freed, and by whom: less of it, as an input
/// frees little and is repeated when it is a finding.
extern "C" const char* __asan_default_options() {
  return "quarantine_size_mb=8:malloc_context_size=3";
}

inline void Require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "not so: %s\n", what);
  std::abort();
}

/// Nothing but the error that a user is told may come out of it: a line for each mistake, none of them empty.
template <typename Act>
void RequireReadableErrors(Act&& act) {
  try {
    act();
  } catch (const servohil::base::UsageError& error) {
    const std::string text = '\n' + std::string(error.what()) + '\n';
    Require(text.find("\n\n") == std::string::npos, "no line of an error is empty");
    const bool printable = std::none_of(
        text.begin(), text.end(), [](char c) { return (c >= 0 && c < ' ' && c != '\n') || c == '\x7f'; });
    Require(printable, "no error has a terminal's escapes");
  }
}
