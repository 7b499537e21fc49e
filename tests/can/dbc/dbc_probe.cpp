/// Reader and codec as a filter, for comparison with an independent implementation.
///
///   dbc_probe FILE         prints the database as JSON, then answers each line of standard input with one:
///     d MESSAGE SIGNAL HEX            the raw value and the physical value; "absent" where the multiplexer
///                                     selects others
///     r MESSAGE SIGNAL RAW HEX        the data with this raw value inserted
///     e MESSAGE SIGNAL PHYSICAL HEX   the data with this physical value encoded, and 1 or 0 (saturated)
/// Wrong files or lines end it with status 2 and a message.

#include <cstdint>
#include <exception>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "can/dbc/codec.hpp"
#include "can/dbc/dbc.hpp"

namespace {

using servohil::can::Database;
using servohil::can::Message;
using servohil::can::Signal;
using servohil::can::ValueType;

nlohmann::json ToJson(const Signal& signal) {
  nlohmann::json values = nlohmann::json::object();
  for (const auto& [value, name] : signal.value_names) values[std::to_string(value)] = name;
  return {{"name", signal.name},
          {"start_bit", signal.start_bit},
          {"length_bits", signal.length_bits},
          {"little_endian", signal.little_endian},
          {"is_signed", signal.is_signed},
          {"factor", signal.factor},
          {"offset", signal.offset},
          {"minimum", signal.minimum},
          {"maximum", signal.maximum},
          {"unit", signal.unit},
          {"comment", signal.comment},
          {"values", values},
          {"multiplexing", signal.multiplexing},
          {"selected_by", signal.selected_by},
          {"is_float", signal.type != ValueType::kInteger},
          {"start_raw", signal.start_raw}};
}

nlohmann::json ToJson(const Database& database) {
  nlohmann::json messages = nlohmann::json::array();
  for (const Message& message : database.messages) {
    nlohmann::json signals = nlohmann::json::array();
    for (const Signal& signal : message.signals) signals.push_back(ToJson(signal));
    messages.push_back({{"name", message.name},
                        {"id", message.id},
                        {"extended", message.extended},
                        {"fd", message.fd},
                        {"bit_rate_switch", message.bit_rate_switch},
                        {"cycle_ms", message.cycle_ms},
                        {"size_bytes", message.size_bytes},
                        {"sender", message.sender},
                        {"comment", message.comment},
                        {"signals", signals}});
  }
  return messages;
}

std::vector<std::uint8_t> FromHex(const std::string& hex) {
  std::vector<std::uint8_t> data;
  for (std::size_t at = 0; at + 1 < hex.size(); at += 2) {
    data.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(at, 2), nullptr, 16)));
  }
  return data;
}

std::string ToHex(const std::vector<std::uint8_t>& data) {
  std::ostringstream hex;
  for (const std::uint8_t byte : data) hex << std::hex << std::setw(2) << std::setfill('0') << int{byte};
  return hex.str();
}

std::string Answer(const Database& database, const std::string& line) {
  std::istringstream words(line);
  std::string command;
  std::string message;
  std::string name;
  std::string value;
  words >> command >> message >> name;
  if (command != "d") words >> value;
  std::string hex;
  words >> hex;
  const Message& layout = database.RequireMessage(message);
  const Signal& signal = database.RequireSignal(layout, name);
  std::vector<std::uint8_t> data = FromHex(hex);
  std::ostringstream answer;
  answer << std::setprecision(17);
  if (command == "d" && !servohil::can::Carries(layout, signal, data)) {
    answer << "absent";
  } else if (command == "d") {
    const std::int64_t raw = servohil::can::ExtractRaw(signal, data);
    answer << (signal.is_signed ? std::to_string(raw) : std::to_string(static_cast<std::uint64_t>(raw)))
           << " " << servohil::can::Decode(signal, data);
  } else if (command == "r") {
    const std::int64_t raw =
        signal.is_signed ? std::stoll(value) : static_cast<std::int64_t>(std::stoull(value));
    servohil::can::InsertRaw(signal, raw, data);
    answer << ToHex(data);
  } else {
    const bool inside = servohil::can::Encode(signal, std::stod(value), data);
    answer << ToHex(data) << " " << inside;
  }
  return answer.str();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw servohil::base::UsageError("usage: dbc_probe FILE");
    const Database database = servohil::can::ReadDbc(argv[1]);
    std::cout << ToJson(database) << std::endl;
    for (std::string line; std::getline(std::cin, line);) std::cout << Answer(database, line) << std::endl;
    return 0;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
