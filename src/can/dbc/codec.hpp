#pragma once
/// Signals in and out of frame data. Bytes are shifted, never cast: the same on any host.

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "can/dbc/dbc.hpp"

namespace servohil::can {

/// Raw value of a signal, sign-extended. Real-time safe. @pre the signal lies inside `data`
std::int64_t ExtractRaw(const Signal& signal, std::span<const std::uint8_t> data) noexcept;
/// Writes the low `length_bits` of raw; other bits stay. Real-time safe. @pre as above
void InsertRaw(const Signal& signal, std::int64_t raw, std::span<std::uint8_t> data) noexcept;

/// Returns the raw value whose bits `number` has in the signal's field: modulo its width, so that 1 in a
/// signed field of one bit is -1, and -1 in an unsigned one of 8 is 255. @return nothing where it does not
/// fit in
std::optional<std::int64_t> RawInField(const Signal& signal, std::int64_t number) noexcept;
/// Returns the name of a raw value in VAL_, compared by its bits; empty: it has none.
std::string NameOfRaw(const Signal& signal, std::int64_t raw);

/// Whether `data` has the signal: multiplexed ones only while the selector has their value. Real-time safe.
bool Carries(const Message& message, const Signal& signal, std::span<const std::uint8_t> data) noexcept;

/// Physical value: raw * factor + offset (raw taken as unsigned where the signal is, as IEEE 754 number where
/// it is one). Integers beyond 2^53 are rounded to a double: IsExact().
double Decode(const Signal& signal, std::span<const std::uint8_t> data) noexcept;
/// Whether this raw value lies in the signal's stated range, where one is stated (minimum below maximum).
/// Integers are compared in raw values: 41 x 0.1 is 4.1000000000000005 in doubles and means the maximum 4.1.
/// An IEEE 754 number next to a limit is the limit. NaN lies outside. Real-time safe.
bool IsInStatedRange(const Signal& signal, std::int64_t raw) noexcept;
/// Returns how far the value that a frame carries may be from the value that was meant: half a step of an
/// integer, two units in the last place of an IEEE 754 number, and what decoding rounds. In the signal's
/// unit. Real-time safe.
double RoundingOf(const Signal& signal, double physical) noexcept;
/// Whether a double holds this raw value. Where it does not, ExtractRaw() is the value.
bool IsExact(const Signal& signal, std::int64_t raw) noexcept;
/// Writes the nearest representable value of `physical`, saturating at what the raw field holds and at the
/// stated range. NaN writes the minimum; into an IEEE 754 number, NaN. @return false when it saturated (or
/// NaN)
bool Encode(const Signal& signal, double physical, std::span<std::uint8_t> data) noexcept;

}  // namespace servohil::can
