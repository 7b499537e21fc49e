#pragma once
/// What faults a run lets in, and requests for them under these permissions.

#include <optional>
#include <string>

#include "fault_words/injection_words.hpp"
#include "simulation/request.hpp"

namespace servohil::fault_words {

/// Which faults there can be, and whether any may be injected.
struct Permissions {
  FaultContext faults;
  bool armed;                 ///< faults may be injected
  std::string why_not_armed;  ///< what to say where they may not
};

struct PermittedInjection {
  simulation::Request request;
  std::string warning;  ///< it would have no effect, and why; empty: it has
};

/// Returns the request that injects a fault.
/// @throws UsageError with the nearest right name, the range, or why none may be injected; FaultUnsupported
PermittedInjection RequestInjection(const std::string& fault, const Words& words,
                                    const Permissions& permissions);

/// Returns the request that clears a fault, or all (nothing). @throws UsageError with the nearest right name
simulation::Request RequestClear(const std::optional<std::string>& fault, const Words& words,
                                 const Permissions& permissions);

}  // namespace servohil::fault_words
