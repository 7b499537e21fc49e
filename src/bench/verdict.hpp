#pragma once
/// The one answer of `servohil check`.

#include <optional>
#include <string>

#include "bench/findings.hpp"
#include "bench/measurement.hpp"

namespace servohil::bench {

struct Verdict {
  std::optional<int> fit_wake_ticks;  ///< smallest that holds; nothing: UNFIT
  bool as_configured = false;         ///< fit at loop.wake_ticks or better
  std::string text;                   ///< "FIT at 0.1 ms", "FIT at n ticks per wake", or "UNFIT: reasons"
};

/// A bench is fit when nothing was found bad and the loop holds. @param configured_ticks  loop.wake_ticks
Verdict Judge(const Findings& findings, const Measurement& measurement, int configured_ticks);

}  // namespace servohil::bench
