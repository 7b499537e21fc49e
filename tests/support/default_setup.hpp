#pragma once
/// The default configuration with its DBC, bound and at rest: where the application's tests begin.

#include "configuration/configuration.hpp"
#include "emulator/simulation_task.hpp"
#include "signal_map/signal_map.hpp"
#include "support/paths.hpp"

namespace servohil::testing {

/// Numbers of the messages that the default configuration publishes.
enum : std::size_t { kPosition, kPressures, kRelay, kBus, kSafety, kStatus, kMessageCount };

inline const std::string kConfigurationFile = ConfigFile("servohil.toml");

struct DefaultSetup {
  explicit DefaultSetup(const std::vector<std::string>& settings = {})
      : configuration(configuration::LoadConfiguration(kConfigurationFile, settings)),
        derived(configuration.model),
        start(model::SteadyStateAt(derived, configuration.start_x3_in)),
        signal_map(configuration) {}

  emulator::TaskOptions Options() const {
    emulator::TaskOptions options;
    options.loop = configuration.loop;
    options.cycle_ticks = signal_map.Cycles();
    options.tell_lateness = signal_map.MessagesCarrying("recent_lateness_ms");
    return options;
  }

  configuration::Configuration configuration;
  model::Derived derived;
  model::SteadyState start;
  signal_map::SignalMap signal_map;
};

/// A governor whose frames are all valid.
class Governor {
 public:
  explicit Governor(emulator::SimulationTask& task) : task_(task) {}

  void Send(double p1_psi) {
    command_.p1_psi = p1_psi;
    ++command_.counts.Of(simulation::FrameVerdict::kValid);
    ++command_.good;
    ++command_.good_in_a_row;
    task_.PutCommand(command_);
  }

 private:
  emulator::SimulationTask& task_;
  simulation::Command command_;
};

}  // namespace servohil::testing
