#include "thesis/cases.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <type_traits>

#include "base/formatted.hpp"
#include "configuration/rest.hpp"

namespace servohil::thesis {
namespace {

std::string Text(double value) {
  return base::Formatted("%.15g", value);
}

std::vector<std::string> Settings(const Row& row) {
  std::vector<std::string> settings;
  const auto set = [&](const char* key, const std::string& value) {
    settings.push_back(std::string(key) + "=" + value);
  };
  set("model.physics", "thesis");
  set("servo.underlap_in", Text(row.underlap_in));
  set("servo.relay_piston_clearance_in", Text(row.clearance_in));
  set("servo.relay_plunger_clearance_in", Text(row.clearance_in));
  set("servo.bulk_modulus_psi", Text(row.bulk_modulus_psi));
  set("cam.shape", row.two_slope_cam ? "two_slope" : "single");
  set("cam.alpha", Text(row.alpha));
  set("cam.x3_star_in", Text(row.x3_star_in));
  set("friction.coulomb_psi", Text(row.coulomb_psi));
  set("stabilizer.enabled", row.stabilizer ? "true" : "false");
  if (row.stabilizer) {
    set("stabilizer.capillary_diameter_in", Text(row.stabilizer->d7_in));
    set("stabilizer.capillary_length_in", Text(row.stabilizer->l7_in));
    set("stabilizer.oil_volume_in3", Text(row.stabilizer->va_in3));
    set("stabilizer.gas_volume_in3", Text(row.stabilizer->va_in3));
  }
  return settings;
}

/// Every key that the model reads, with its value.
std::vector<std::string> ModelKeys(configuration::Configuration configuration) {
  constexpr std::array kModel = {"model.", "oil.",      "orifice.",    "servo.", "supply.",
                                 "cam.",   "friction.", "stabilizer.", "load."};
  std::vector<std::string> all;
  for (const configuration::Key& key : configuration::KeyTable()) {
    const std::string_view name = key.name;
    if (std::ranges::none_of(kModel, [&](const char* prefix) { return name.starts_with(prefix); })) continue;
    const std::string value = std::visit(
        [&](auto place) -> std::string {
          const auto& v = place(configuration);
          using T = std::remove_cvref_t<decltype(v)>;
          if constexpr (std::is_same_v<T, double>) return Text(v);
          if constexpr (std::is_same_v<T, bool>) return v ? "true" : "false";
          if constexpr (std::is_same_v<T, int>) return std::to_string(v);
          if constexpr (std::is_same_v<T, std::string>) return v.empty() ? "\"\"" : v;
          if constexpr (std::is_enum_v<T>) return configuration::NamesOf(v)[static_cast<std::size_t>(v)];
          return "";
        },
        key.place);
    if (!value.empty()) all.push_back(std::string(name) + "=" + value);
  }
  return all;
}

}  // namespace

Case LoadCase(const configuration::ConfigurationOptions& base, const Row& row) {
  std::vector<std::string> settings = Settings(row);
  std::vector<std::string> all = base.settings;
  all.insert(all.end(), settings.begin(), settings.end());
  const configuration::Configuration configuration = configuration::LoadConfiguration(base.file, all);
  const model::Derived derived(configuration.model);
  return {std::move(settings), ModelKeys(configuration), configuration.model, derived,
          configuration::RequireSteadyStateAt(derived, kX3In)};
}

}  // namespace servohil::thesis
