#pragma once
/// Raw values that SAE J1939-71 sets aside: they say that there is no value.

#include <cstdint>

#include "can/dbc/dbc.hpp"

namespace servohil::can {

/// What a raw value of a J1939 parameter stands for.
enum class J1939Value : std::uint8_t {
  kValid,
  kReserved,      ///< parameter specific indicators and what is reserved
  kError,         ///< error indicator
  kNotAvailable,  ///< not available, or not requested
};

/// Tells the value from the indicators, by SAE J1939-71, 5.1.5 (Tables 1 and 2): of parameters of 8 bits and
/// more the most significant 8 bits count (FF not available, FE error, FB to FD reserved); of discrete ones
/// of 2 to 7 bits all ones is not available, one less is an error. Signed and IEEE 754 signals, and those of
/// one bit, have no indicators.
/// @param raw  as ExtractRaw(). Real-time safe.
constexpr J1939Value J1939ValueOf(const Signal& signal, std::int64_t raw) noexcept {
  if (signal.is_signed || signal.type != ValueType::kInteger || signal.length_bits < 2)
    return J1939Value::kValid;
  const auto bits = static_cast<std::uint64_t>(raw);
  const int counted = signal.length_bits < 8 ? signal.length_bits : 8;
  const std::uint64_t top = bits >> static_cast<unsigned>(signal.length_bits - counted);
  const std::uint64_t not_available = (1U << static_cast<unsigned>(counted)) - 1U;
  if (top == not_available) return J1939Value::kNotAvailable;
  if (top == not_available - 1) return J1939Value::kError;
  constexpr std::uint64_t kFirstReserved = 0xFB;
  return counted == 8 && top >= kFirstReserved ? J1939Value::kReserved : J1939Value::kValid;
}

}  // namespace servohil::can
