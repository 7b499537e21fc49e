#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/exit_status.hpp"
#include "base/formatted.hpp"
#include "commands/commands.hpp"
#include "run/bus_setup.hpp"
#include "run/candump.hpp"
#include "signal_map/json.hpp"
#include "signal_map/report.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::commands {
namespace {

struct DbcOptions {
  configuration::ConfigurationOptions configuration;
  std::filesystem::path log;
  bool json = false;
};

using Id = std::pair<bool, std::uint32_t>;  // extended, identifier

/// Of all that the files describe, the message of a frame; null: unknown.
const can::Message* MessageOf(const signal_map::SignalMap& signal_map, const can::Frame& frame) {
  for (const signal_map::ReceivedMessage& incoming : signal_map.IncomingMessages()) {
    if (incoming.pattern.Matches(frame.id, frame.extended)) return incoming.message;
  }
  for (const can::Database& file : signal_map.Databases().files) {
    const auto found =
        std::find_if(file.messages.begin(), file.messages.end(), [&](const can::Message& message) {
          return message.id == frame.id && message.extended == frame.extended;
        });
    if (found != file.messages.end()) return &file.RequireMessage(found->name);
  }
  return nullptr;
}

std::string Line(const can::Message& message, const signal_map::SignalMap& signal_map,
                 const can::Frame& frame) {
  if (frame.remote) return message.name + ": remote request";
  if (int{frame.size} < message.size_bytes)
    return message.name + base::Formatted(": %d of its %d bytes", int{frame.size}, message.size_bytes);
  const std::string meaning = signal_map::DescribeMeaning(signal_map, frame);
  return message.name + ": " + signal_map::DescribeFrame(message, frame) +
         (meaning.empty() ? "" : "  => " + meaning);
}

/// Each frame that the files describe, an object a line.
void DecodeLogToJson(const DbcOptions& options, const signal_map::SignalMap& signal_map) {
  for (const auto& [frame, interface, line_number] : run::ReadCandump(options.log)) {
    const can::Message* const message = MessageOf(signal_map, frame);
    if (message == nullptr) continue;
    nlohmann::json line = signal_map::FrameToJson(*message, signal_map, frame);
    line["time_s"] = static_cast<double>(frame.receive_time_ns) / 1e9;
    std::cout << line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
  }
}

void DecodeLog(const DbcOptions& options, const signal_map::SignalMap& signal_map) {
  std::map<std::string, unsigned long long> known;
  std::map<Id, unsigned long long> unknown;
  const std::vector<run::LoggedFrame> frames = run::ReadCandump(options.log);
  for (const auto& [frame, interface, line_number] : frames) {
    const can::Message* const message = MessageOf(signal_map, frame);
    if (message == nullptr) {
      ++unknown[{frame.extended, frame.id}];
      continue;
    }
    ++known[message->name];
    const double t_s =
        static_cast<double>(frame.receive_time_ns - frames.front().frame.receive_time_ns) / 1e9;
    std::cout << base::Formatted("%12.6f  ", t_s) << Line(*message, signal_map, frame) << '\n';
  }
  std::cout << "frames  ";
  for (const auto& [name, count] : known) std::cout << name << ' ' << count << ", ";
  unsigned long long others = 0;
  for (const auto& [id, count] : unknown) others += count;
  std::cout << others << " of " << unknown.size() << " unknown identifiers\n";
  for (const auto& [id, count] : unknown)
    std::cout << "unknown " << signal_map::IdText(id.second, id.first) << ": " << count << '\n';
}

}  // namespace

void AddDbcCommand(CLI::App& program, int& exit_status) {
  auto options = std::make_shared<DbcOptions>();
  CLI::App& command = *program.add_subcommand(
      "dbc",
      "What will be received and sent: messages, signals, conversions, bus load; or decodes a candump log");
  AddOptions(command, options->configuration);
  command.add_option("--decode", options->log, "candump log to decode with the DBC files and the mapping")
      ->type_name("LOG");
  command.add_flag("--json", options->json, "for pipelines: all in one object; of a log an object a line");
  command.callback([options, &exit_status] {
    const configuration::Configuration configuration = options->configuration.Load();
    const signal_map::SignalMap signal_map(configuration);
    if (options->json && options->log.empty()) {
      std::cout << signal_map::SignalMapToJson(signal_map, configuration.can)
                       .dump(2, ' ', false, nlohmann::json::error_handler_t::replace)
                << '\n';
    } else if (options->json) {
      DecodeLogToJson(*options, signal_map);
    } else if (options->log.empty()) {
      std::cout << signal_map::DescribeSignalMap(signal_map, configuration.can);
      if (!signal_map.CycleMismatch().empty()) std::cout << "warning  " << signal_map.CycleMismatch() << '\n';
    } else {
      DecodeLog(*options, signal_map);
    }
    std::cout << std::flush;
    if (options->log.empty()) run::RequireBusCarries(signal_map, configuration.can);
    exit_status = base::kExitOk;
  });
}

}  // namespace servohil::commands
