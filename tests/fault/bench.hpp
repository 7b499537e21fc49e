#pragma once
/// A servomotor at rest under which the tests put faults: the full physics, nominal, through app::Simulation.

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "fault/catalogue.hpp"
#include "model/nominal.hpp"
#include "simulation/simulation.hpp"

namespace servohil::fault {

/// What gtest tells of a fault.
inline void PrintTo(const Spec& spec, std::ostream* out) {
  *out << spec.name;
}

}  // namespace servohil::fault

namespace servohil::fault::testing {

using model::Parameters;

inline Parameters Full() {
  Parameters p = model::testing::Nominal();
  p.physics = model::Physics::kFull;
  return p;
}
inline Parameters WithStabilizer() {
  Parameters p = Full();
  p.stabilizer.enabled = true;
  return p;
}

inline const Spec& Named(std::string_view name) {
  for (const Spec& spec : Catalogue()) {
    if (name == spec.name) return spec;
  }
  throw std::invalid_argument("no fault " + std::string(name));
}

/// With the presets for what `values` leaves out.
inline Injection Of(std::string_view name, const std::vector<double>& values = {}) {
  Injection injection;
  injection.id = Named(name).id;
  for (std::size_t i = 0; i < kMaxParameters; ++i)
    injection.values[i] = i < values.size() ? values[i] : Named(name).parameters[i].preset;
  return injection;
}

/// Why this servomotor does not have what the fault acts on, on a bus in real time.
inline const char* UnsupportedBy(const Spec& spec, const Parameters& p) {
  return Unsupported(spec, Surroundings{.unfaulted = &p});
}

/// The parameters under the whole of one fault.
inline Parameters Under(const Parameters& p, std::string_view name, const std::vector<double>& values = {}) {
  Parameters faulted = p;
  const Injection injection = Of(name, values);
  std::get<ParameterAct>(Named(name).act)(faulted, injection.values, 1.0, 0.0);
  return faulted;
}

class Bench {
 public:
  explicit Bench(const Parameters& p = Full(), double x3_in = 4.0)
      : parameters(p),
        start(model::SteadyStateAt(model::Derived(p), x3_in)),
        p1_psi(start.p1_psi),
        simulation(p, start) {
    if (!start) throw std::invalid_argument("no steady state");
  }

  Bench& Inject(std::string_view name, const std::vector<double>& values = {}, std::uint64_t ramp_ticks = 0,
                std::uint64_t for_ticks = 0) {
    Injection injection = Of(name, values);
    injection.start_tick = simulation.Now().tick + 1;
    injection.ramp_ticks = ramp_ticks;
    injection.ramp_out_ticks = ramp_ticks;
    injection.for_ticks = for_ticks;
    if (!simulation.Faults().Inject(injection)) throw std::length_error("no room");
    return *this;
  }

  const simulation::Sample& Run(int ticks) {
    for (int i = 0; i < ticks; ++i) simulation.Tick(p1_psi);
    EXPECT_FALSE(simulation.Now().model_fault);
    return simulation.Now();
  }
  /// Long enough to come to rest: the slowest mode of the nominal servomotor takes 50 ms.
  const simulation::Sample& Settle() {
    Run(30'000);
    EXPECT_NEAR(State().v3_in_s, 0.0, 1e-6);
    return simulation.Now();
  }

  const model::State& State() const { return simulation.Now().state; }
  model::Outputs Outputs() const { return simulation.Outputs(); }
  double Opening() const { return Outputs().x2_in - Outputs().x4_in; }  ///< of the plunger [in]

  Parameters parameters;
  model::SteadyState start;
  double p1_psi;
  simulation::Simulation simulation;
};

}  // namespace servohil::fault::testing
