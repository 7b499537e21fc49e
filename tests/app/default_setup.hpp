#pragma once
/// The default configuration with its DBC, bound and at rest: where the application's tests begin.

#include "servohil/app/configuration.hpp"
#include "servohil/app/contract.hpp"
#include "servohil/app/simulation_task.hpp"
#include "servohil/can/dbc.hpp"

namespace servohil::app::testing {

inline constexpr const char* kConfigurationFile = SERVOHIL_CONFIG_DIR "/servohil.toml";

struct DefaultSetup {
  explicit DefaultSetup(const std::vector<std::string>& settings = {})
      : configuration(LoadConfiguration(kConfigurationFile, settings)),
        derived(configuration.model),
        start(model::SteadyStateAt(derived, configuration.start_x3_in)),
        contract(can::ReadDbc(configuration.can.dbc), configuration.publish) {}

  TaskOptions Options() const {
    TaskOptions options;
    options.loop = configuration.loop;
    for (std::size_t i = 0; i < kPublishedCount; ++i)
      options.cycle_ticks[i] = contract.CycleTicks(static_cast<Published>(i));
    return options;
  }

  Configuration configuration;
  model::Derived derived;
  model::SteadyState start;
  Contract contract;
};

}  // namespace servohil::app::testing
