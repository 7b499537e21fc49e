#include "scenario/expectation_reader.hpp"

#include <algorithm>

#include "base/formatted.hpp"
#include "base/nearest_name.hpp"
#include "model/ticks.hpp"

namespace servohil::scenario {
namespace {

using Kind = Expectation::Kind;
using FaultStarts = std::vector<std::pair<std::string, std::uint64_t>>;

constexpr double kMost = 1e12;
constexpr int kMaxModes = 16;  // as many as signal Mode has room for

/// The nearest name, or one that begins so, or all of them.
std::string Suggestion(const std::string& wrong, const std::vector<std::string>& names) {
  const auto begins_so = [&](const std::string& name) { return name.rfind(wrong, 0) == 0; };
  const auto longer = std::find_if(names.begin(), names.end(), begins_so);
  return base::DidYouMean(
      wrong, names,
      longer != names.end() ? "did you mean " + *longer + "?" : "must be one of " + base::Listed(names));
}

const recording::SampleColumn* RequireQuantity(Entry& entry) {
  const std::string name = entry.RequireText("quantity");
  std::vector<std::string> names;
  for (const recording::SampleColumn& column : recording::SampleColumns()) {
    if (!column.repeatable || !column.compressible) continue;  // the machine's doing, or a hash
    if (name == column.name) return &column;
    names.emplace_back(column.name);
  }
  entry.Fail("quantity", Suggestion(name, names));
}

simulation::Mode RequireMode(Entry& entry, const std::string& key) {
  const std::string name = entry.RequireText(key);
  std::vector<std::string> names;
  for (int i = 0; i < kMaxModes; ++i) {
    const auto mode = static_cast<simulation::Mode>(i);
    if (name == simulation::NameOf(mode)) return mode;
    if (std::find(names.begin(), names.end(), simulation::NameOf(mode)) == names.end())
      names.emplace_back(simulation::NameOf(mode));
  }
  entry.Fail(key, Suggestion(name, names));
}

/// from_s and to_s: the whole scenario where they are not given.
void ReadTime(Entry& entry, std::uint64_t duration_ticks, Expectation& e) {
  const double duration_s = model::SecondsOf(duration_ticks);
  e.from_tick = model::TicksOf(entry.Number("from_s", 0.0, duration_s, "s").value_or(0.0));
  e.to_tick = model::TicksOf(entry.Number("to_s", 0.0, duration_s, "s").value_or(duration_s));
  if (e.to_tick <= e.from_tick && entry.Has("to_s")) entry.Fail("to_s", "must be after from_s");
  if (e.to_tick <= e.from_tick)
    entry.Fail("from_s", base::Formatted("must be before the end, %g s", duration_s));
}

void ReadWithin(Entry& entry, std::uint64_t duration_ticks, Expectation& e) {
  e.within = entry.RequireNumber("within", 0.0, kMost, e.quantity->unit);
  e.of = entry.RequireNumber("of", -kMost, kMost, e.quantity->unit);
  const auto by_s = entry.Number("by_s", 0.0, model::SecondsOf(duration_ticks), "s");
  e.kind = by_s ? Kind::kSettles : Kind::kWithin;
  if (by_s && entry.Has("from_s")) entry.Fail("from_s", "must not stand beside by_s");
  ReadTime(entry, duration_ticks, e);
  if (by_s) e.from_tick = model::TicksOf(*by_s);
  if (e.to_tick <= e.from_tick) entry.Fail("by_s", "must be before the end of its time");
}

void ReadBetween(Entry& entry, std::uint64_t duration_ticks, Expectation& e) {
  e.kind = Kind::kBetween;
  e.above = entry.Number("above", -kMost, kMost, e.quantity->unit).value_or(e.above);
  e.below = entry.Number("below", -kMost, kMost, e.quantity->unit).value_or(e.below);
  if (e.above >= e.below) entry.Fail("below", "must be more than above");
  ReadTime(entry, duration_ticks, e);
}

void ReadOscillation(Entry& entry, std::uint64_t duration_ticks, Expectation& e) {
  const bool calm = entry.Has("oscillation_below");
  e.kind = calm ? Kind::kCalm : Kind::kOscillates;
  e.peak_to_peak = entry.RequireNumber(calm ? "oscillation_below" : "oscillation_above", 0.0, kMost,
                                       std::string(e.quantity->unit) + ", peak to peak");
  if (e.peak_to_peak == 0.0 && !calm) entry.Fail("oscillation_above", "must be more than 0");
  if (const auto range = calm ? std::nullopt : entry.Range("frequency_hz", 0.0, 5e3, "Hz")) {
    e.lowest_hz = range->first;
    e.highest_hz = range->second;
  }
  ReadTime(entry, duration_ticks, e);
}

/// `mode` within `within_ms` after `after_s`, or after the fault named by `after`.
void ReadModeBecomes(Entry& entry, std::uint64_t duration_ticks, const FaultStarts& faults, Expectation& e) {
  e.kind = Kind::kModeBecomes;
  e.mode = RequireMode(entry, "mode");
  const double duration_s = model::SecondsOf(duration_ticks);
  if (const auto after_s = entry.Number("after_s", 0.0, duration_s, "s")) {
    e.from_tick = model::TicksOf(*after_s);
    if (entry.Has("after")) entry.Fail("after", "must not stand beside after_s");
  } else {
    e.after = entry.RequireText("after");
    const auto fault =
        std::find_if(faults.begin(), faults.end(), [&](const auto& one) { return one.first == e.after; });
    std::vector<std::string> names;
    for (const auto& [name, tick] : faults) names.push_back(name);
    if (fault == faults.end())
      entry.Fail("after", names.empty() ? "must be a fault of this file without a trigger; there is none"
                                        : Suggestion(e.after, names));
    e.from_tick = fault->second;
  }
  const double most_ms = 1e3 * (duration_s - model::SecondsOf(e.from_tick));
  e.to_tick = e.from_tick + model::TicksOf(entry.RequireNumber("within_ms", 0.1, most_ms, "ms") / 1e3);
}

}  // namespace

Expectation ReadExpectation(Entry& entry, std::uint64_t duration_ticks, const FaultStarts& fault_starts) {
  Expectation e;
  e.line = entry.Line();
  if (entry.Has("never")) {
    e.kind = Kind::kModeNever;
    e.mode = RequireMode(entry, "never");
    ReadTime(entry, duration_ticks, e);
  } else if (entry.Has("mode")) {
    ReadModeBecomes(entry, duration_ticks, fault_starts, e);
  } else {
    e.quantity = RequireQuantity(entry);
    if (entry.Has("within") || entry.Has("of")) {
      ReadWithin(entry, duration_ticks, e);
    } else if (entry.Has("above") || entry.Has("below")) {
      ReadBetween(entry, duration_ticks, e);
    } else if (entry.Has("oscillation_below") || entry.Has("oscillation_above")) {
      ReadOscillation(entry, duration_ticks, e);
    } else {
      entry.FailWhole(
          "it expects nothing: give within and of, above, below, oscillation_below, oscillation_above, mode "
          "or "
          "never");
    }
  }
  entry.RefuseOthers();
  return e;
}

}  // namespace servohil::scenario
