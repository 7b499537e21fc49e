// Any bytes as a DBC file: read, or refused with one line; what is read encodes and decodes.

#include <cmath>

#include "fuzz.hpp"
#include "servohil/can/codec.hpp"
#include "servohil/can/dbc.hpp"

namespace {

/// Every signal lies inside its message, and a raw value that is written is read back.
void UseEverySignal(const servohil::can::Database& database) {
  constexpr std::size_t kLargestMessage = 64;
  for (const servohil::can::Message& message : database.messages) {
    std::array<std::uint8_t, kLargestMessage> bytes{};
    const auto size = static_cast<std::size_t>(message.size_bytes);
    if (size > bytes.size()) continue;
    const std::span<std::uint8_t> data(bytes.data(), size);
    for (const servohil::can::Signal& signal : message.signals) {
      servohil::can::InsertRaw(signal, -1, data);
      const std::int64_t raw = servohil::can::ExtractRaw(signal, data);
      servohil::can::InsertRaw(signal, raw, data);
      Require(servohil::can::ExtractRaw(signal, data) == raw, "a raw value that is written is read back");
      servohil::can::Encode(signal, servohil::can::Decode(signal, data), data);
    }
  }
}

}  // namespace

int FuzzOne(std::string_view text) {
  RequireReadableErrors([&] { UseEverySignal(servohil::can::ParseDbc(text, "fuzz.dbc")); });
  return 0;
}
