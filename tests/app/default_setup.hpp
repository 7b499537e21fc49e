#pragma once
/// The default configuration with its DBC, bound and at rest: where the application's tests begin.

#include "servohil/app/configuration.hpp"
#include "servohil/app/contract.hpp"
#include "servohil/app/simulation_task.hpp"

namespace servohil::app::testing {

/// Numbers of the messages that the default configuration publishes.
enum : std::size_t { kPosition, kPressures, kRelay, kBus, kSafety, kStatus, kMessageCount };

inline constexpr const char* kConfigurationFile = SERVOHIL_CONFIG_DIR "/servohil.toml";

struct DefaultSetup {
  explicit DefaultSetup(const std::vector<std::string>& settings = {})
      : configuration(LoadConfiguration(kConfigurationFile, settings)),
        derived(configuration.model),
        start(model::SteadyStateAt(derived, configuration.start_x3_in)),
        contract(configuration) {}

  TaskOptions Options() const {
    TaskOptions options;
    options.loop = configuration.loop;
    options.cycle_ticks = contract.Cycles();
    options.tell_lateness = contract.MessagesCarrying("recent_lateness_ms");
    return options;
  }

  Configuration configuration;
  model::Derived derived;
  model::SteadyState start;
  Contract contract;
};

/// A governor whose frames are all valid.
class Governor {
 public:
  explicit Governor(SimulationTask& task) : task_(task) {}

  void Send(double p1_psi) {
    command_.p1_psi = p1_psi;
    ++command_.counts.Of(FrameVerdict::kValid);
    ++command_.good;
    ++command_.good_in_a_row;
    task_.PutCommand(command_);
  }

 private:
  SimulationTask& task_;
  Command command_;
};

}  // namespace servohil::app::testing
