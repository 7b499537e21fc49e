#pragma once
/// What `servohil check` finds: one line each, with a verdict, the value found, and the command that mends
/// it.

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace servohil::bench {

enum class Grade : std::uint8_t {
  kOk,
  kWarn,  ///< costs latency, or may: the measurement tells how much
  kBad    ///< `servohil run --rt require` would refuse, or the bus would not carry what it should
};

struct Finding {
  std::string name;  ///< what was looked at: "governor"
  Grade grade = Grade::kOk;
  std::string value;  ///< what was found
  std::string fix;    ///< a command where there is one; empty where nothing is to be mended
};

using Findings = std::vector<Finding>;

inline bool AnyBad(const Findings& findings) {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.grade == Grade::kBad; });
}

}  // namespace servohil::bench
