#include "bench/report.hpp"

#include <nlohmann/json.hpp>

#include "base/formatted.hpp"

namespace servohil::bench {
namespace {

using nlohmann::ordered_json;

const char* Name(Grade grade) {
  switch (grade) {
    case Grade::kOk:
      return "OK";
    case Grade::kWarn:
      return "WARN";
    case Grade::kBad:
      return "BAD";
  }
  return "?";
}

/// OK; NEAR: none was late, but the margin is gone; LATE.
const char* Name(const Level& level) {
  if (level.holds) return "OK";
  return level.late_wakes == 0 ? "NEAR" : "LATE";
}

double Us(std::uint64_t ns) {
  return static_cast<double>(ns) / 1e3;
}

std::string Line(const Finding& finding) {
  std::string text =
      base::Formatted("%-4s  %-13s", Name(finding.grade), finding.name.c_str()) + finding.value + '\n';
  if (!finding.fix.empty()) text += "        fix: " + finding.fix + '\n';
  return text;
}

std::string Line(const Level& level) {
  return base::Formatted(
      "%-4s  %d tick%s per wake: worst %.3f ms after its deadline, %llu of %llu wakes late; latency median "
      "%.1f us, 99.9 %% %.1f us; compute median %.1f us, worst %.1f us; %.1f s\n",
      Name(level), level.wake_ticks, level.wake_ticks == 1 ? "" : "s",
      static_cast<double>(level.worst_lateness_ns) / 1e6, static_cast<unsigned long long>(level.late_wakes),
      static_cast<unsigned long long>(level.wakes), Us(level.latency_median_ns), Us(level.latency_p999_ns),
      Us(level.compute_median_ns), Us(level.compute_worst_ns), level.measured_s);
}

ordered_json Object(const Finding& finding) {
  return {{"name", finding.name},
          {"verdict", Name(finding.grade)},
          {"value", finding.value},
          {"fix", finding.fix}};
}

ordered_json Object(const Level& level) {
  return {{"wake_ticks", level.wake_ticks},
          {"verdict", Name(level)},
          {"measured_s", level.measured_s},
          {"wakes", level.wakes},
          {"late_wakes", level.late_wakes},
          {"worst_lateness_ns", level.worst_lateness_ns},
          {"latency_median_ns", level.latency_median_ns},
          {"latency_999_ns", level.latency_p999_ns},
          {"compute_median_ns", level.compute_median_ns},
          {"compute_worst_ns", level.compute_worst_ns}};
}

template <typename Items>
ordered_json List(const Items& items) {
  ordered_json list = ordered_json::array();
  for (const auto& item : items) list.push_back(Object(item));
  return list;
}

}  // namespace

std::string AsText(const Report& report) {
  std::string text;
  for (const Finding& finding : report.findings) text += Line(finding);
  text += base::Formatted("the loop, beside %zu threads that load memory and disk:\n",
                          report.measurement.load_threads);
  for (const Level& level : report.measurement.levels) text += Line(level);
  return text + "verdict  " + report.verdict.text + '\n';
}

std::string AsJson(const Report& report) {
  const Verdict& verdict = report.verdict;
  const ordered_json out = {
      {"findings", List(report.findings)},
      {"measurement",
       {{"load_threads", report.measurement.load_threads}, {"levels", List(report.measurement.levels)}}},
      {"verdict",
       {{"text", verdict.text},
        {"fit_wake_ticks",
         verdict.fit_wake_ticks ? ordered_json(*verdict.fit_wake_ticks) : ordered_json(nullptr)},
        {"configured_wake_ticks", report.loop.wake_ticks},
        {"as_configured", verdict.as_configured}}}};
  return out.dump(2) + '\n';
}

}  // namespace servohil::bench
