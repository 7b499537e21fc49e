#pragma once
/// The two ways a start-up can fail. The text is one line for the user: what, where, and what would be right.

#include <stdexcept>

namespace servohil {

/// Wrong usage, configuration or input file: exit status 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The machine lacks something (interface, permission, device): exit status 3.
struct EnvironmentError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace servohil
