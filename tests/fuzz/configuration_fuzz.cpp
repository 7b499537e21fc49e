// Any bytes as a configuration file, and behind a zero byte as a --set: read, or refused with one line for
// each mistake; what is read is bound to the messages and signals of the DBC files that we have.

#include "configuration/configuration.hpp"
#include "fuzz.hpp"
#include "signal_map/binding.hpp"

namespace {

constexpr const char* kFile = SERVOHIL_CONFIG_DIR "/fuzz.toml";

/// Whatever can.dbc names: files are not what is tested here.
const servohil::can::Databases& AllMessages() {
  static const auto all = servohil::can::ReadDbcs({SERVOHIL_CONFIG_DIR "/servohil.dbc",
                                                   SERVOHIL_CONFIG_DIR "/examples/foreign/governor.dbc",
                                                   SERVOHIL_CONFIG_DIR "/examples/foreign/valve_drive.dbc"});
  return all;
}

void Bind(const servohil::configuration::Configuration& configuration) {
  const auto incoming = servohil::signal_map::BindCommand(AllMessages(), configuration);
  const auto outgoing = servohil::signal_map::BindPublished(AllMessages(), configuration);
  Require(!incoming.empty() && incoming.front().p1 != nullptr, "there is a P1");
  for (const servohil::signal_map::PublishedMessage& message : outgoing)
    Require(!message.pages.empty() && message.cycle_ms > 0, "a message has a content and a cycle time");
  servohil::signal_map::CheckIdentifiers(incoming, outgoing);
}

}  // namespace

int FuzzOne(std::string_view bytes) {
  const std::size_t zero = bytes.find('\0');
  const std::string_view text = bytes.substr(0, zero);
  std::vector<std::string> settings;
  if (zero != std::string_view::npos) settings.emplace_back(bytes.substr(zero + 1));
  RequireReadableErrors([&] { Bind(servohil::configuration::ParseConfiguration(text, kFile, settings)); });
  return 0;
}
