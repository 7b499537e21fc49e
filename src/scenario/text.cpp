#include <cmath>

#include "base/formatted.hpp"
#include "model/ticks.hpp"
#include "scenario/scenario.hpp"

namespace servohil::scenario {
namespace {

std::string Between(const Expectation& e) {
  return base::Formatted(" from %g s to %g s", model::SecondsOf(e.from_tick), model::SecondsOf(e.to_tick));
}

std::string Limits(const Expectation& e) {
  std::string text;
  if (std::isfinite(e.above)) text += " above " + WithUnit(e.above, *e.quantity);
  if (std::isfinite(e.above) && std::isfinite(e.below)) text += " and";
  if (std::isfinite(e.below)) text += " below " + WithUnit(e.below, *e.quantity);
  return text;
}

std::string Frequency(const Expectation& e) {
  if (e.lowest_hz == 0.0 && !std::isfinite(e.highest_hz)) return "";
  return base::Formatted(" at %g to %g Hz", e.lowest_hz, e.highest_hz);
}

}  // namespace

std::string NameOf(const recording::SampleColumn& quantity) {
  std::string name = quantity.name;
  std::string end = std::string("_") + quantity.unit;
  for (char& c : end) c = c == '/' || c == ' ' ? '_' : c;
  const bool has_unit = *quantity.unit != 0 && name.size() > end.size() &&
                        name.compare(name.size() - end.size(), end.size(), end) == 0;
  return has_unit ? name.substr(0, name.size() - end.size()) : name;
}

std::string WithUnit(double value, const recording::SampleColumn& quantity) {
  return base::Formatted("%.5g%s%s", value, *quantity.unit != 0 ? " " : "", quantity.unit);
}

std::string TextOf(const Expectation& e) {
  switch (e.kind) {
    case Expectation::Kind::kWithin:
      return NameOf(*e.quantity) + " within " + WithUnit(e.within, *e.quantity) + " of " +
             WithUnit(e.of, *e.quantity) + Between(e);
    case Expectation::Kind::kSettles:
      return NameOf(*e.quantity) + " settles within " + WithUnit(e.within, *e.quantity) + " of " +
             WithUnit(e.of, *e.quantity) +
             base::Formatted(" by %g s, until %g s", model::SecondsOf(e.from_tick),
                             model::SecondsOf(e.to_tick));
    case Expectation::Kind::kBetween:
      return NameOf(*e.quantity) + Limits(e) + Between(e);
    case Expectation::Kind::kCalm:
      return "no oscillation of " + NameOf(*e.quantity) + " above " + WithUnit(e.peak_to_peak, *e.quantity) +
             " peak to peak" + Between(e);
    case Expectation::Kind::kOscillates:
      return NameOf(*e.quantity) + " oscillates by at least " + WithUnit(e.peak_to_peak, *e.quantity) +
             " peak to peak" + Frequency(e) + Between(e);
    case Expectation::Kind::kModeBecomes:
      return std::string("mode becomes ") + simulation::NameOf(e.mode) +
             base::Formatted(" within %g ms of ", model::SecondsOf(e.to_tick - e.from_tick) * 1e3) +
             (e.after.empty() ? base::Formatted("%g s", model::SecondsOf(e.from_tick)) : e.after);
    default:
      return std::string("mode never ") + simulation::NameOf(e.mode) + Between(e);
  }
}

}  // namespace servohil::scenario
