#include "bench/verdict.hpp"

namespace servohil::bench {
namespace {

std::string LoopText(int wake_ticks) {
  return wake_ticks == 1 ? "0.1 ms" : std::to_string(wake_ticks) + " ticks per wake";
}

std::string NamesOfBad(const Findings& findings) {
  std::string names;
  for (const Finding& finding : findings) {
    if (finding.grade == Grade::kBad) names += (names.empty() ? "" : ", ") + finding.name;
  }
  return names;
}

std::string Unfit(const Findings& findings, const Measurement& measurement) {
  const std::optional<int> loop = measurement.Fit();
  if (!AnyBad(findings)) return "UNFIT: ticks are late, or nearly so, at any number of ticks per wake";
  return "UNFIT: " + NamesOfBad(findings) +
         (loop ? "; the loop alone holds at " + LoopText(*loop) : "; and ticks are late, or nearly so");
}

}  // namespace

Verdict Judge(const Findings& findings, const Measurement& measurement, int configured_ticks) {
  const std::optional<int> fit = AnyBad(findings) ? std::nullopt : measurement.Fit();
  if (!fit) return {std::nullopt, false, Unfit(findings, measurement)};
  if (*fit <= configured_ticks) return {fit, true, "FIT at " + LoopText(*fit)};
  const std::string n = std::to_string(*fit);
  return {fit, false,
          "FIT at " + LoopText(*fit) + ", not at loop.wake_ticks = " + std::to_string(configured_ticks) +
              ": --set loop.wake_ticks=" + n};
}

}  // namespace servohil::bench
