#pragma once
/// The faults there are: one table, from which help, documentation and checks come.

#include <array>
#include <cstdint>
#include <span>

#include "servohil/model/parameters.hpp"

namespace servohil::fault {

inline constexpr std::size_t kMostParameters = 3;
using Values = std::array<double, kMostParameters>;

struct ParameterSpec {
  const char* name;  ///< "fraction"; null: there is no such parameter
  const char* unit;  ///< empty where there is none
  double minimum;    ///< inclusive
  double maximum;
  double preset;  ///< where none is given
  const char* meaning;
};

/// What a fault acts on.
enum class Part : std::uint8_t { kOil, kSupply, kRelay, kPiston, kLoad, kStabilizer };
const char* NameOf(Part part) noexcept;

/// What a fault does to the parameters: `share` of it (0 to 1, the ramp), `t_s` after its start.
using Act = void (*)(model::Parameters& p, const Values& values, double share, double t_s) noexcept;

struct Spec {
  std::uint8_t id;   ///< the same for ever: recordings hold it
  const char* name;  ///< "air_entrainment"
  Part part;
  std::array<ParameterSpec, kMostParameters> parameters;
  const char* effect;  ///< one sentence
  Act act;
  bool full_only;  ///< the thesis' equations do not have what it acts on
  bool needs_stabilizer;
  bool varies;  ///< changes at each tick, not only while it ramps
};

std::span<const Spec> Catalogue() noexcept;
/// Null: there is none of this name or number.
const Spec* Find(std::uint8_t id) noexcept;

/// Why the model that is configured does not have what the fault acts on; null where it has. Real-time safe.
const char* Unsupported(const Spec& spec, const model::Parameters& unfaulted) noexcept;

}  // namespace servohil::fault
