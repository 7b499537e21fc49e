#pragma once
/// Exit statuses of the program.

namespace servohil::base {

inline constexpr int kExitOk = 0;
inline constexpr int kExitNotValid = 1;     ///< the run was not valid, or the replay differs
inline constexpr int kExitFail = 1;         ///< a scenario's expectation was not met
inline constexpr int kExitUsage = 2;        ///< usage or configuration
inline constexpr int kExitEnvironment = 3;  ///< the machine lacks something
inline constexpr int kExitInvalid = 4;      ///< the run of a scenario supports no verdict

}  // namespace servohil::base
