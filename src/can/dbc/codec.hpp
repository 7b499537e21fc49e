#pragma once
/// Signals in and out of frame data. Bytes are shifted, never cast: the same on any host.

#include <cstdint>
#include <span>

#include "can/dbc/dbc.hpp"

namespace servohil::can {

/// Raw value of a signal, sign-extended. Real-time safe. @pre the signal lies inside `data`
std::int64_t ExtractRaw(const Signal& signal, std::span<const std::uint8_t> data) noexcept;
/// Writes the low `length_bits` of raw; other bits stay. Real-time safe. @pre as above
void InsertRaw(const Signal& signal, std::int64_t raw, std::span<std::uint8_t> data) noexcept;

/// Whether `data` has the signal: multiplexed ones only while the selector has their value. Real-time safe.
bool Carries(const Message& message, const Signal& signal, std::span<const std::uint8_t> data) noexcept;

/// Physical value: raw * factor + offset (raw taken as unsigned where the signal is, as IEEE 754 number where
/// it is one). Integers beyond 2^53 are rounded to a double: IsExact().
double Decode(const Signal& signal, std::span<const std::uint8_t> data) noexcept;
/// Whether a double holds this raw value. Where it does not, ExtractRaw() is the value.
bool IsExact(const Signal& signal, std::int64_t raw) noexcept;
/// Writes the nearest representable value of `physical`, saturating at what the raw field holds and at the
/// stated range. NaN writes the minimum; into an IEEE 754 number, NaN. @return false when it saturated (or
/// NaN)
bool Encode(const Signal& signal, double physical, std::span<std::uint8_t> data) noexcept;

}  // namespace servohil::can
