// Any bytes as a DBC file, and behind a zero byte as a second one: read, or refused with one line; what is
// read encodes and decodes.

#include <cmath>

#include "can/dbc/codec.hpp"
#include "can/dbc/dbc.hpp"
#include "can/frame_bits.hpp"
#include "fuzz.hpp"

namespace {

namespace can = servohil::can;

/// It lies inside its message, and a raw value that is written is read back.
void Use(const can::Message& message, const can::Signal& signal, std::span<std::uint8_t> data) {
  can::InsertRaw(signal, -1, data);
  const std::int64_t raw = can::ExtractRaw(signal, data);
  can::InsertRaw(signal, raw, data);
  Require(can::ExtractRaw(signal, data) == raw, "a raw value that is written is read back");
  const double value = can::Decode(signal, data);
  can::Encode(signal, value, data);
  can::Encode(signal, signal.start_raw, data);
  Require(can::IsExact(signal, 0), "a double holds 0");
  Require(can::Carries(message, signal, data) || signal.multiplexing == can::Multiplexing::kSelected,
          "only a multiplexed signal is not always there");
}

void Use(const can::Databases::Found& found) {
  std::array<std::uint8_t, 64> bytes{};
  const can::Message& message = *found.message;
  const auto size = static_cast<std::size_t>(message.size_bytes);
  Require(size <= bytes.size(), "a frame holds a message that is used");
  Require(can::WorstCaseBits(message).nominal > 0, "a frame has a length");
  for (const can::Signal& signal : message.signals) {
    Use(message, signal, std::span(bytes.data(), size));
    Require(&found.database->RequireSignal(message, signal.name) == &signal, "a signal is found by its name");
  }
  RequireReadableErrors([&] { found.database->RequireSignal(message, message.name); });
}

void UseEveryMessage(const can::Databases& databases) {
  for (const can::Database& database : databases.files) {
    for (const can::Message& message : database.messages)
      RequireReadableErrors([&] { Use(databases.RequireMessage(message.name)); });
  }
  RequireReadableErrors([&] { databases.RequireMessage("M"); });
}

}  // namespace

int FuzzOne(std::string_view text) {
  const std::size_t zero = text.find('\0');
  RequireReadableErrors([&] {
    can::Databases databases;
    databases.files.push_back(can::ParseDbc(text.substr(0, zero), "fuzz.dbc"));
    if (zero != std::string_view::npos)
      databases.files.push_back(can::ParseDbc(text.substr(zero + 1), "second.dbc"));
    UseEveryMessage(databases);
  });
  return 0;
}
