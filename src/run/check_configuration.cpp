#include "run/check_configuration.hpp"

#include <spdlog/spdlog.h>

#include <iostream>

#include "base/error.hpp"
#include "base/exit_status.hpp"
#include "configuration/envelope_check.hpp"
#include "configuration/rest.hpp"
#include "run/bus_setup.hpp"
#include "run/log.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::run {
namespace {

/// Carries out one check after the other, whatever the others found.
class Checks {
 public:
  template <typename Check>
  void Run(Check&& check) {
    try {
      check();
    } catch (const base::UsageError& error) {
      TellEachLine(error.what());
      passed_ = false;
    }
  }
  bool Passed() const noexcept { return passed_; }

 private:
  bool passed_ = true;
};

}  // namespace

int CheckConfiguration(const configuration::ConfigurationOptions& options,
                       const std::vector<std::string>& buses) {
  const configuration::Configuration configuration = options.Load();
  const model::Derived derived(configuration.model);
  Checks checks;
  checks.Run([&] { configuration::RequireSteadyStateAt(derived, configuration.start_x3_in); });
  checks.Run([&] {
    if (const std::string warning = configuration::CheckEnvelope(configuration, derived); !warning.empty())
      spdlog::warn("{}", warning);
  });
  checks.Run([&] {
    const signal_map::SignalMap signal_map(configuration);
    CheckBusLoad(signal_map, configuration.can);
  });
  checks.Run([&] { WantedBuses(buses, configuration); });
  if (!checks.Passed()) return base::kExitUsage;
  std::cout << "configuration ok: "
            << (options.file.empty() ? configuration::DefaultConfigurationFile() : options.file).string()
            << '\n';
  return base::kExitOk;
}

}  // namespace servohil::run
