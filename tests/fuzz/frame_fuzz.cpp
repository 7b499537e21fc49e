// Any frames from the bus, one after the other: a command within its range, or refused with a reason; error
// frames are told in one line.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "can/error_frame.hpp"
#include "emulator/command_validator.hpp"
#include "fuzz.hpp"
#include "signal_map/signal_map.hpp"

namespace {

namespace can = servohil::can;

/// A configuration with its messages, and who guards its command.
struct Side {
  servohil::configuration::Configuration configuration;
  servohil::signal_map::SignalMap signal_map;

  Side(const char* file, const std::vector<std::string>& settings)
      : configuration(
            servohil::configuration::LoadConfiguration(std::string(SERVOHIL_CONFIG_DIR) + file, settings)),
        signal_map(configuration) {}

  servohil::emulator::CommandValidator Validator() const {
    const servohil::signal_map::ReceivedMessage& command = signal_map.IncomingMessages().front();
    servohil::emulator::CommandValidator validator(configuration.safety, command.cycle_ms);
    if (command.protection)
      validator.Check(*command.protection, static_cast<unsigned>(configuration.can.command.max_counter_jump));
    return validator;
  }
};

Side Protected(const std::string& profile, std::vector<std::string> settings) {
  settings.insert(settings.end(), {"can.command.e2e=" + profile, "can.command.counter=Counter",
                                   "can.command.max_counter_jump=2", "safety.p1_rate_psi_s=1000"});
  if (profile != "counter") settings.emplace_back("can.command.checksum=Checksum");
  return {"/servohil.toml", settings};
}

const std::vector<Side>& Sides() {
  static const std::vector<Side> sides = [] {
    std::vector<Side> all;
    constexpr const char* kForeign = "/examples/foreign/servohil.toml";
    all.emplace_back("/servohil.toml", std::vector<std::string>{});
    all.emplace_back(kForeign, std::vector<std::string>{});
    all.emplace_back(kForeign, std::vector<std::string>{"can.command.e2e=j1939_counter_checksum"});
    all.push_back(Protected("counter", {}));
    all.push_back(Protected("crc8_j1850", {}));
    all.push_back(Protected("autosar_p1", {"can.command.data_id=291"}));
    all.push_back(Protected("autosar_p11", {"can.command.data_id=291"}));
    return all;
  }();
  return sides;
}

/// Takes bytes off the input's front; zeros at its end.
class Source {
 public:
  explicit Source(std::string_view bytes) : bytes_(bytes) {}
  bool AtEnd() const { return bytes_.empty(); }
  std::uint8_t Byte() {
    if (bytes_.empty()) return 0;
    const auto byte = static_cast<std::uint8_t>(bytes_.front());
    bytes_.remove_prefix(1);
    return byte;
  }

 private:
  std::string_view bytes_;
};

/// Flags, identifier or the number of a message that is known, size, data.
can::Frame FrameFrom(Source& source, const servohil::signal_map::SignalMap& signal_map) {
  const std::uint8_t flags = source.Byte();
  const auto has = [&](unsigned bit) { return (flags & (1U << bit)) != 0; };
  can::Frame frame;
  frame.extended = has(0);
  frame.remote = has(1);
  frame.fd = has(2);
  frame.bit_rate_switch = has(3);
  frame.error = has(5);
  if (has(4)) {
    const auto incoming = signal_map.IncomingMessages();
    const can::Message& known = *incoming[source.Byte() % incoming.size()].message;
    frame.id = known.id;
    frame.extended = known.extended;
  } else {
    for (int i = 0; i < 4; ++i) frame.id = frame.id << 8U | source.Byte();
    frame.id &= frame.extended || frame.error ? 0x1FFF'FFFFU : 0x7FFU;
  }
  frame.size = static_cast<std::uint8_t>(source.Byte() % (frame.fd ? 65 : 9));
  std::generate_n(frame.data.begin(), frame.size, [&] { return source.Byte(); });
  if (const auto& protection = signal_map.IncomingMessages().front().protection;
      has(6) && protection && frame.size >= protection->size_bytes)
    can::Protect(*protection, frame.id, source.Byte() % protection->modulus, frame.data);
  return frame;
}

void RequireInRange(const servohil::signal_map::SignalMap& signal_map, const can::Frame& frame,
                    const servohil::signal_map::Demand& demand) {
  Require(!frame.remote && !frame.error, "remote and error frames demand nothing");
  if (!demand.p1_psi) return;
  const servohil::signal_map::ReceivedMessage& command = signal_map.IncomingMessages().front();
  const can::Signal& p1 = *command.p1;
  Require(std::isfinite(*demand.p1_psi), "P1 is a number");
  Require(!(p1.minimum < p1.maximum) || (*demand.p1_psi >= command.p1_to_psi(p1.minimum) &&
                                         *demand.p1_psi <= command.p1_to_psi(p1.maximum)),
          "P1 is within the range that the DBC states");
}

void RequireValid(const Side& side, const can::Frame& frame, const servohil::simulation::Command& newest) {
  const auto& protection = side.signal_map.IncomingMessages().front().protection;
  const std::span<const std::uint8_t> data(frame.data.data(), frame.size);
  Require(!protection || can::IsIntact(*protection, frame.id, data), "a valid frame is intact");
  Require(newest.p1_psi >= side.configuration.safety.p1_minimum_psi &&
              newest.p1_psi <= side.configuration.safety.p1_maximum_psi,
          "P1 is within the range that the configuration states");
}

void TellError(const can::Frame& frame, can::ErrorTotals& errors) {
  errors.Take(frame);
  Require(errors.DescribeLast().find('\n') == std::string::npos, "an error frame is told in one line");
}

}  // namespace

int FuzzOne(std::string_view bytes) {
  Source source(bytes);
  const Side& side = Sides()[source.Byte() % Sides().size()];
  servohil::emulator::CommandValidator validator = side.Validator();
  can::ErrorTotals errors;
  for (std::int64_t time_ns = 0; !source.AtEnd();) {
    const std::int64_t age_ns = std::int64_t{source.Byte()} * 100'000;
    time_ns += age_ns;
    const can::Frame frame = FrameFrom(source, side.signal_map);
    if (frame.error) TellError(frame, errors);
    servohil::signal_map::CommandRejection why{};
    const auto demand = side.signal_map.Decode(frame, why);
    if (demand) RequireInRange(side.signal_map, frame, *demand);
    if (!side.signal_map.IsCommand(frame)) continue;
    const auto verdict = validator.Judge(frame, demand, why, {time_ns, age_ns, time_ns});
    if (verdict == servohil::simulation::FrameVerdict::kValid) RequireValid(side, frame, validator.Newest());
  }
  return 0;
}
