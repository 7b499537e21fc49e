/// Parameter sets drawn from the ranges of every key of the model: nothing that the configuration accepts
/// makes a state that is not finite, whatever P1 does between 0 and 300 psi.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <string_view>

#include "base/error.hpp"
#include "simulation/simulation.hpp"
#include "support/default_setup.hpp"

namespace servohil::signal_map {
namespace {

class AnySettings {
 public:
  explicit AnySettings(unsigned seed) : random_(seed) {}

  double Between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  /// About one key in six with a value from its range, uniform in its logarithm where it spans decades.
  std::vector<std::string> Draw() {
    std::vector<std::string> settings;
    for (const configuration::Key& key : configuration::KeyTable()) {
      if (!IsOfTheModel(key.name) || Between(0.0, 1.0) > 1.0 / 6.0) continue;
      if (std::holds_alternative<double& (*)(configuration::Configuration&)>(key.place)) {
        char text[100];
        std::snprintf(text, sizeof text, "%s=%.17g", key.name, Value(key));
        settings.emplace_back(text);
      }
    }
    if (Between(0.0, 1.0) < 0.3) settings.emplace_back("stabilizer.enabled=true");
    if (Between(0.0, 1.0) < 0.3) settings.emplace_back("cam.shape=two_slope");
    if (Between(0.0, 1.0) < 0.3) settings.emplace_back("load.beyond=hold");
    if (Between(0.0, 1.0) < 0.3) settings.emplace_back("oil.name=iso_vg_32");
    return settings;
  }

 private:
  static bool IsOfTheModel(std::string_view name) {
    for (const std::string_view section :
         {"oil.", "orifice.", "servo.", "supply.", "cam.", "friction.", "stabilizer."})
      if (name.starts_with(section)) return true;
    return false;
  }
  double Value(const configuration::Key& key) {
    if (key.minimum > 0.0 && key.maximum > 100.0 * key.minimum)
      return std::exp(Between(std::log(key.minimum), std::log(key.maximum)));
    return Between(key.minimum, key.maximum);
  }

  std::mt19937 random_;
};

TEST(AnyConfiguration, IsFiniteUnderAnyP1) {
  AnySettings any(3);  // any seed
  int refused = 0;
  int runs = 0;
  for (int i = 0; i < 4'000 && runs < 150; ++i) {
    const std::vector<std::string> settings = any.Draw();
    try {
      const testing::DefaultSetup setup(settings);
      if (!setup.start) continue;
      ++runs;
      simulation::Simulation simulation(setup.configuration.model, setup.start);
      double p1_psi = 0.0;
      for (int tick = 0; tick < 1'200; ++tick) {
        if (tick % 150 == 0)
          p1_psi = tick % 300 == 0 ? any.Between(0.0, 300.0) : any.Between(0.0, 1.0) < 0.5 ? 0.0 : 300.0;
        const simulation::Sample& sample = simulation.Tick(p1_psi);
        std::string all;
        if (sample.model_fault)
          for (const std::string& one : settings) all += " --set " + one;
        ASSERT_FALSE(sample.model_fault)
            << "tick " << tick << ", P1 " << p1_psi << ", x3 " << sample.state.x3_in << all;
        ASSERT_LE(sample.sub_steps, model::kMaxSubSteps + model::kMaxEvents);
      }
    } catch (const base::UsageError&) {
      ++refused;  // two keys that contradict one another
    }
  }
  EXPECT_EQ(runs, 150);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace servohil::signal_map
