#pragma once
/// Units of signals, and conversion between them.

#include <optional>
#include <string>
#include <string_view>

namespace servohil::signal_map {

/// y = factor x + offset
struct Linear {
  double factor = 1.0;
  double offset = 0.0;

  double operator()(double x) const noexcept { return factor * x + offset; }
  bool IsIdentity() const noexcept { return factor == 1.0 && offset == 0.0; }
};

/// From a value in unit `from` to one in `to`, as DBC files write them: "psi", "bar", "kgf/cm2", "mm/s", ...
/// Pressures are gauge; "bara", "psia" and the like are absolute (standard atmosphere, 14.696 psi). The same
/// text is the same unit, whatever it is, and so are "", "1" and "-". Nothing: they do not measure the same,
/// or one is not known.
std::optional<Linear> Conversion(std::string_view from, std::string_view to);

/// Names of the units that `unit` can be converted to, itself included: "psi, bar, kPa, ..."; empty: not
/// known.
std::string ConvertibleUnits(std::string_view unit);

}  // namespace servohil::signal_map
