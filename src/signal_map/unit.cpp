#include "signal_map/unit.hpp"

#include <algorithm>
#include <array>

#include "model/oil.hpp"

namespace servohil::signal_map {
namespace {

enum class Dimension { kPressure, kLength, kVelocity, kTime };

/// base = factor x + offset; bases: psi gauge, in, in/s, ms.
struct Unit {
  const char* name;
  Dimension dimension;
  double factor;
  double offset = 0.0;
  bool alias = false;  ///< another spelling of one before
};

// Exact by definition: 1 in = 25.4 mm, 1 lb = 0.45359237 kg, standard gravity 9.80665 m/s² (BIPM, NIST SP
// 811).
constexpr double kMmPerIn = 25.4;
constexpr double kGravity = 9.80665;
constexpr double kPaPerPsi = 0.45359237 * kGravity / (0.0254 * 0.0254);
constexpr double kPa = 1.0 / kPaPerPsi;
constexpr double kBar = 1e5 * kPa;
constexpr double kKgfPerCm2 = kGravity * 1e4 * kPa;
constexpr bool kAlias = true;

constexpr Dimension kPressure = Dimension::kPressure;
constexpr double kAbsolute = -model::kAtmospherePsi;

constexpr std::array kUnits = std::to_array<Unit>({
    {"psi", kPressure, 1.0},
    {"psig", kPressure, 1.0, 0.0, kAlias},
    {"PSI", kPressure, 1.0, 0.0, kAlias},
    {"lbf/in2", kPressure, 1.0, 0.0, kAlias},
    {"lbf/in²", kPressure, 1.0, 0.0, kAlias},
    {"bar", kPressure, kBar},
    {"Bar", kPressure, kBar, 0.0, kAlias},
    {"barg", kPressure, kBar, 0.0, kAlias},
    {"bar(g)", kPressure, kBar, 0.0, kAlias},
    {"mbar", kPressure, 1e-3 * kBar},
    {"Pa", kPressure, kPa},
    {"hPa", kPressure, 1e2 * kPa},
    {"kPa", kPressure, 1e3 * kPa},
    {"KPa", kPressure, 1e3 * kPa, 0.0, kAlias},
    {"kPag", kPressure, 1e3 * kPa, 0.0, kAlias},
    {"MPa", kPressure, 1e6 * kPa},
    {"N/mm2", kPressure, 1e6 * kPa, 0.0, kAlias},
    {"N/mm²", kPressure, 1e6 * kPa, 0.0, kAlias},
    {"kgf/cm2", kPressure, kKgfPerCm2},
    {"kgf/cm²", kPressure, kKgfPerCm2, 0.0, kAlias},
    {"kg/cm2", kPressure, kKgfPerCm2, 0.0, kAlias},
    {"kg/cm²", kPressure, kKgfPerCm2, 0.0, kAlias},
    {"at", kPressure, kKgfPerCm2, 0.0, kAlias},
    {"psia", kPressure, 1.0, kAbsolute},
    {"bara", kPressure, kBar, kAbsolute},
    {"bar(a)", kPressure, kBar, kAbsolute, kAlias},
    {"kPaa", kPressure, 1e3 * kPa, kAbsolute},
    {"in", Dimension::kLength, 1.0},
    {"inch", Dimension::kLength, 1.0, 0.0, kAlias},
    {"mm", Dimension::kLength, 1.0 / kMmPerIn},
    {"cm", Dimension::kLength, 10.0 / kMmPerIn},
    {"m", Dimension::kLength, 1000.0 / kMmPerIn},
    {"um", Dimension::kLength, 0.001 / kMmPerIn},
    {"µm", Dimension::kLength, 0.001 / kMmPerIn, 0.0, kAlias},
    {"in/s", Dimension::kVelocity, 1.0},
    {"inch/s", Dimension::kVelocity, 1.0, 0.0, kAlias},
    {"mm/s", Dimension::kVelocity, 1.0 / kMmPerIn},
    {"cm/s", Dimension::kVelocity, 10.0 / kMmPerIn},
    {"m/s", Dimension::kVelocity, 1000.0 / kMmPerIn},
    {"ms", Dimension::kTime, 1.0},
    {"s", Dimension::kTime, 1000.0},
    {"us", Dimension::kTime, 0.001},
    {"µs", Dimension::kTime, 0.001, 0.0, kAlias},
});

const Unit* Find(std::string_view name) {
  const auto* const found =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& unit) { return name == unit.name; });
  return found == kUnits.end() ? nullptr : found;
}

bool IsNone(std::string_view unit) {
  return unit.empty() || unit == "1" || unit == "-";
}

}  // namespace

std::optional<Linear> Conversion(std::string_view from, std::string_view to) {
  if (from == to || (IsNone(from) && IsNone(to))) return Linear{};
  const Unit* const a = Find(from);
  const Unit* const b = Find(to);
  if (a == nullptr || b == nullptr || a->dimension != b->dimension) return std::nullopt;
  if (a->factor == b->factor && a->offset == b->offset) return Linear{};
  return Linear{a->factor / b->factor, (a->offset - b->offset) / b->factor};
}

std::string ConvertibleUnits(std::string_view unit) {
  const Unit* const one = Find(unit);
  std::string names;
  if (one == nullptr) return names;
  for (const Unit& other : kUnits) {
    if (other.dimension == one->dimension && !other.alias)
      names += (names.empty() ? "" : ", ") + std::string(other.name);
  }
  return names;
}

}  // namespace servohil::signal_map
