#pragma once
/// What `servohil run` is asked to do, and what it has read for it.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "configuration/rest.hpp"
#include "configuration/source.hpp"
#include "emulator/emulator.hpp"
#include "run/recording_options.hpp"
#include "run/scenario_options.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::run {

struct RunOptions {
  configuration::ConfigurationOptions configuration;
  std::vector<std::string> buses;
  emulator::Clock clock = emulator::Clock::kReal;
  emulator::RealTime real_time = emulator::RealTime::kPrefer;
  double duration_s = 0.0;
  std::filesystem::path script;
  RecordingOptions recording;
  std::filesystem::path statistics;
  std::string control;
  std::filesystem::path from;
  std::filesystem::path snapshots = ".";
  std::vector<double> snapshot_at_s;
  bool check_configuration = false;
  ScenarioOptions scenario;
};

/// All of it from the configuration, or from a snapshot.
struct RunSetup {
  /// @throws UsageError where anything of it cannot be
  explicit RunSetup(const RunOptions& options)
      : scenario(options.scenario.Open()),
        configuration(LoadFor(scenario.get(), options.configuration)),
        derived(configuration.model),
        start(configuration::RequireSteadyStateAt(derived, configuration.start_x3_in)),
        signal_map(configuration) {}

  std::unique_ptr<scenario::ScenarioFile> scenario;  ///< null: none
  configuration::Configuration configuration;
  model::Derived derived;
  model::SteadyState start;
  signal_map::SignalMap signal_map;
};

/// The loop, the duration and the snapshots.
emulator::TaskOptions TaskOptionsOf(const RunOptions& options, const configuration::LoopSettings& loop);

}  // namespace servohil::run
