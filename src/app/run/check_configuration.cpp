#include "check_configuration.hpp"

#include <spdlog/spdlog.h>

#include <iostream>

#include "bus_setup.hpp"
#include "log.hpp"
#include "servohil/app/contract.hpp"
#include "servohil/app/envelope_check.hpp"
#include "servohil/error.hpp"
#include "servohil/exit_status.hpp"
#include "configuration/rest.hpp"

namespace servohil::app {
namespace {

/// Carries out one check after the other, whatever the others found.
class Checks {
 public:
  template <typename Check>
  void Run(Check&& check) {
    try {
      check();
    } catch (const UsageError& error) {
      TellEachLine(error.what());
      passed_ = false;
    }
  }
  bool Passed() const noexcept { return passed_; }

 private:
  bool passed_ = true;
};

}  // namespace

int CheckConfiguration(const ConfigurationOptions& options, const std::vector<std::string>& buses) {
  const Configuration configuration = options.Load();
  const model::Derived derived(configuration.model);
  Checks checks;
  checks.Run([&] { RequireSteadyStateAt(derived, configuration.start_x3_in); });
  checks.Run([&] {
    if (const std::string warning = CheckEnvelope(configuration, derived); !warning.empty())
      spdlog::warn("{}", warning);
  });
  checks.Run([&] {
    const Contract contract(configuration);
    CheckBusLoad(contract, configuration.can);
  });
  checks.Run([&] { WantedBuses(buses, configuration); });
  if (!checks.Passed()) return kExitUsage;
  std::cout << "configuration ok: "
            << (options.file.empty() ? DefaultConfigurationFile() : options.file).string() << '\n';
  return kExitOk;
}

}  // namespace servohil::app
