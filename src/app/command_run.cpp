#include <poll.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "run_report.hpp"
#include "servohil/app/contract.hpp"
#include "servohil/app/emulator.hpp"
#include "servohil/app/envelope_check.hpp"
#include "servohil/can/dbc.hpp"
#include "servohil/can/interface_state.hpp"
#include "servohil/can/network.hpp"
#include "servohil/error.hpp"
#include "servohil/rt/clock.hpp"

namespace servohil::app {
namespace {

struct Options {
  ConfigurationOptions configuration;
  std::vector<std::string> buses;
  RealTime real_time = RealTime::kPrefer;
  double duration_s = 0.0;
};

/// SIGINT and SIGTERM as a descriptor. Constructed before any thread, so that all inherit the blocked mask.
class StopSignals {
 public:
  StopSignals() {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigaddset(&set, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    fd_ = signalfd(-1, &set, SFD_CLOEXEC);
    if (fd_ < 0) throw EnvironmentError("no signal descriptor: too many open files");
    std::signal(SIGPIPE, SIG_IGN);
  }
  ~StopSignals() { close(fd_); }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  int Fd() const { return fd_; }

 private:
  int fd_;
};

std::vector<std::string> ResolveBuses(const std::vector<std::string>& wanted, const CanSettings& can) {
  std::vector<std::string> urls;
  for (const std::string& url : wanted) {
    if (url != "auto") {
      urls.push_back(url);
      continue;
    }
    urls.push_back(can::AutomaticUrl(can.interfaces));
    std::string looked_for;
    for (const std::string& interface : can.interfaces)
      looked_for += (looked_for.empty() ? "" : ", ") + interface;
    spdlog::info("--can auto: {} (looked for {})", urls.back(), looked_for);
  }
  return urls;
}

void CheckBusLoad(const Contract& contract, const CanSettings& can) {
  constexpr double kWarnAbove = 0.7;
  double bits_per_s = 0.0;
  std::string parts;
  for (const Contract::Load& load : contract.BusLoad(can.command_cycle_ms)) {
    bits_per_s += load.bits_per_s;
    parts += (parts.empty() ? "" : ", ") + load.message + " every " + std::to_string(load.cycle_ms) + " ms";
  }
  const double share = bits_per_s / can.bit_rate_bit_s;
  char text[64];
  std::snprintf(text, sizeof text, "%.1f %% of %d bit/s", 100.0 * share, can.bit_rate_bit_s);
  const std::string line = std::string("bus load at worst-case stuffing ") + text + ": " + parts;
  if (share > 1.0) throw UsageError(line + "; more than the bus carries: raise the publish.*_ms cycle times");
  if (share > kWarnAbove) {
    spdlog::warn("{}; above 70 % other nodes will wait: raise the publish.*_ms cycle times", line);
  } else {
    spdlog::info("{}", line);
  }
}

/// State of each bus that has one, and whether its bit rate is the one that the bus load was computed for.
void ReportBuses(const can::Network& network, int bit_rate_bit_s) {
  constexpr std::string_view kKernel = "socketcan:";
  for (const auto& bus : network.Buses()) {
    if (const std::string state = bus->State(); !state.empty()) spdlog::info("{}: {}", bus->Name(), state);
    if (bus->Name().rfind(kKernel, 0) != 0) continue;
    const auto real = can::InterfaceBitRate(bus->Name().substr(kKernel.size()));
    if (real && *real != static_cast<std::uint32_t>(bit_rate_bit_s)) {
      spdlog::warn("{} runs at {} bit/s, can.bit_rate_bit_s = {}: the bus load above is wrong by that ratio",
                   bus->Name(), *real, bit_rate_bit_s);
    }
  }
}

/// Until a stop signal or the end of the duration; on a terminal with a status line a second.
void Watch(Emulator& emulator, const can::Network& network, const StopSignals& signals) {
  const bool terminal = isatty(STDOUT_FILENO) != 0;
  constexpr std::int64_t kStatusNs = 1'000'000'000;
  std::int64_t last_ns = rt::MonotonicNs();
  std::uint64_t last_tick = 0;
  for (;;) {
    pollfd fds[] = {{signals.Fd(), POLLIN, 0}, {emulator.FinishedFd(), POLLIN, 0}};
    const int timeout_ms =
        terminal ? static_cast<int>(std::max<std::int64_t>(0, last_ns + kStatusNs - rt::MonotonicNs()) /
                                    1'000'000) +
                       1
                 : -1;
    if (poll(fds, 2, timeout_ms) > 0) break;
    const std::int64_t now_ns = rt::MonotonicNs();
    Telemetry telemetry;
    if (now_ns - last_ns < kStatusNs || !emulator.TakeNewest(telemetry)) continue;
    const double ticks_per_s =
        static_cast<double>(telemetry.sample.tick - last_tick) * 1e9 / static_cast<double>(now_ns - last_ns);
    std::cout << "\r\033[K" << StatusLine(telemetry, ticks_per_s, network.Statistics()) << std::flush;
    last_ns = now_ns;
    last_tick = telemetry.sample.tick;
  }
  if (terminal) std::cout << '\n';
}

int Run(const Options& options) {
  const StopSignals signals;
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("", std::make_shared<spdlog::sinks::stderr_sink_mt>()));
  spdlog::set_pattern("servohil: %l: %v");

  const Configuration configuration = options.configuration.Load();
  const model::Derived derived(configuration.model);
  if (const std::string warning = CheckEnvelope(configuration, derived); !warning.empty())
    spdlog::warn("{}", warning);
  const model::SteadyState start = RequireSteadyStateAt(derived, configuration.start_x3_in);
  const Contract contract(can::ReadDbc(configuration.can.dbc), configuration.publish);
  CheckBusLoad(contract, configuration.can);

  can::BusOptions bus_options;
  bus_options.wanted = {{contract.CommandId(), contract.CommandIsExtended()}};
  bus_options.bit_rate_bit_s = static_cast<std::uint32_t>(configuration.can.bit_rate_bit_s);
  can::Network network(
      ResolveBuses(options.buses.empty() ? configuration.can.buses : options.buses, configuration.can),
      bus_options);

  ReportBuses(network, configuration.can.bit_rate_bit_s);

  EmulatorOptions emulator_options;
  emulator_options.loop = configuration.loop;
  emulator_options.real_time = options.real_time;
  emulator_options.duration_ticks =
      static_cast<std::uint64_t>(std::llround(options.duration_s / model::kTickS));
  Emulator emulator(derived, start, contract, network, emulator_options);
  std::string missing;
  for (const std::string& one : emulator.Start()) missing += (missing.empty() ? "" : "; ") + one;
  if (!missing.empty()) spdlog::warn("not fully real-time: {}", missing);

  std::string buses;
  for (const auto& bus : network.Buses()) {
    buses += (buses.empty() ? "" : ", ") + bus->Name();
    if (const std::string hint = bus->ConnectHint(); !hint.empty()) spdlog::info("{}", hint);
  }
  std::printf(
      "ready: %s; at rest at x3 %.4f in, P1 %.4f psi, until the first command; wake-up every %.1f ms\n",
      buses.c_str(), start.state.x3_in, start.p1_psi, configuration.loop.wake_ticks / 10.0);
  std::fflush(stdout);
  Watch(emulator, network, signals);
  emulator.Stop();
  std::cout << Summary(emulator, network, configuration.loop) << std::flush;
  return JudgeRun(emulator.Final()).valid ? kExitOk : kExitNotValid;
}

}  // namespace

void AddRunCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *program.add_subcommand("run", "Runs the emulator in real time on a CAN bus");
  options->configuration.AddTo(command);
  command
      .add_option(
          "--can", options->buses,
          "bus: socketcan:IFACE, slcan:pty[:LINK], slcan:/dev/TTY, or auto; repeatable; default: can.buses "
          "(auto: vcan0 or can0 if the kernel has it, else slcan:pty)")
      ->type_name("URL")
      ->take_all();
  command
      .add_option("--rt", options->real_time,
                  "real-time scheduling and locked memory: require (refuse to run without), prefer (default: "
                  "warn), off")
      ->type_name("require|prefer|off")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, RealTime>{
              {"require", RealTime::kRequire}, {"prefer", RealTime::kPrefer}, {"off", RealTime::kOff}},
          CLI::ignore_case));
  command
      .add_option("--duration", options->duration_s,
                  "ends after this time [s]; default: at SIGINT or SIGTERM")
      ->type_name("S")
      ->check(CLI::Range(model::kTickS, 1e9));
  command.callback([options, &exit_status] { exit_status = Run(*options); });
}

}  // namespace servohil::app
