#include "can/dbc/codec.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "can/dbc/bit_chunks.hpp"

namespace servohil::can {
namespace {

/// Interval of raw values, as doubles: [first, end), both powers of two or 0, hence exact.
struct RawField {
  double first;
  double end;
};

RawField FieldOf(const Signal& signal) noexcept {
  if (signal.is_signed) {
    const double half = std::ldexp(1.0, signal.length_bits - 1);
    return {-half, half};
  }
  return {0.0, std::ldexp(1.0, signal.length_bits)};
}

/// All ones, or 0111...1 where signed.
std::int64_t LargestRaw(const Signal& signal) noexcept {
  const int ones = signal.is_signed ? signal.length_bits - 1 : signal.length_bits;
  const std::uint64_t all = std::numeric_limits<std::uint64_t>::max();
  return ones == 0 ? 0 : static_cast<std::int64_t>(all >> static_cast<unsigned>(64 - ones));
}

struct RawLimits {
  double low;
  double high;
};

/// Raw values whose physical value lies in the stated range. A millionth of a step is granted: (12.107 + 1) /
/// 0.0002 is 65534.999999999993 in doubles and means 65535.
RawLimits StatedRange(const Signal& signal) noexcept {
  constexpr double kGrace = 1e-6;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (signal.minimum == 0.0 && signal.maximum == 0.0) return {-kInfinity, kInfinity};
  const double a = (signal.minimum - signal.offset) / signal.factor;
  const double b = (signal.maximum - signal.offset) / signal.factor;
  const RawLimits limits{std::ceil(std::min(a, b) - kGrace), std::floor(std::max(a, b) + kGrace)};
  if (limits.low <= limits.high) return limits;
  return {-kInfinity, kInfinity};  // no raw value lies inside: the range cannot be meant
}

/// The raw bits as the number that they are.
double RawNumber(const Signal& signal, std::int64_t raw) noexcept {
  const auto bits = static_cast<std::uint64_t>(raw);
  switch (signal.type) {
    case ValueType::kFloat32:
      return double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))};
    case ValueType::kFloat64:
      return std::bit_cast<double>(bits);
    case ValueType::kInteger:
      break;
  }
  return signal.is_signed ? static_cast<double>(raw) : static_cast<double>(bits);
}

bool EncodeInteger(const Signal& signal, double physical, std::span<std::uint8_t> data) noexcept {
  const RawField field = FieldOf(signal);
  const RawLimits range = StatedRange(signal);
  const double wanted = std::round((physical - signal.offset) / signal.factor);
  const double lowest = signal.factor < 0.0 ? range.high : range.low;  // raw value of the physical minimum
  const double x = std::isnan(wanted) ? std::clamp(lowest, field.first, field.end)
                                      : std::clamp(wanted, range.low, range.high);
  std::int64_t raw = 0;
  if (x < field.first) {
    raw = static_cast<std::int64_t>(field.first);
  } else if (x >= field.end) {
    raw = LargestRaw(signal);
  } else if (signal.is_signed) {
    raw = static_cast<std::int64_t>(x);
  } else {
    raw = static_cast<std::int64_t>(static_cast<std::uint64_t>(x));
  }
  InsertRaw(signal, raw, data);
  return x == wanted && x >= field.first && x < field.end;
}

bool EncodeFloat(const Signal& signal, double physical, std::span<std::uint8_t> data) noexcept {
  const bool single = signal.type == ValueType::kFloat32;
  const bool stated = signal.minimum != 0.0 || signal.maximum != 0.0;
  const double inside = stated && signal.minimum <= signal.maximum
                            ? std::clamp(physical, signal.minimum, signal.maximum)
                            : physical;
  const double wanted = (inside - signal.offset) / signal.factor;
  const double largest =
      single ? double{std::numeric_limits<float>::max()} : std::numeric_limits<double>::max();
  const double number = std::clamp(wanted, -largest, largest);  // NaN stays NaN
  const std::uint64_t bits = single ? std::bit_cast<std::uint32_t>(static_cast<float>(number))
                                    : std::bit_cast<std::uint64_t>(number);
  InsertRaw(signal, static_cast<std::int64_t>(bits), data);
  return inside == physical && number == wanted;
}

}  // namespace

std::int64_t ExtractRaw(const Signal& signal, std::span<const std::uint8_t> data) noexcept {
  std::uint64_t raw = 0;
  ForEachChunk(signal, [&](const BitChunk& chunk) {
    const unsigned byte = data[chunk.byte];
    const std::uint64_t bits = (byte >> static_cast<unsigned>(chunk.low_bit)) & chunk.Mask();
    raw |= bits << static_cast<unsigned>(chunk.raw_bit);
  });
  if (signal.is_signed) {
    const std::uint64_t sign = std::uint64_t{1} << static_cast<unsigned>(signal.length_bits - 1);
    raw = (raw ^ sign) - sign;  // modulo 2^64: extends the sign bit
  }
  return static_cast<std::int64_t>(raw);
}

void InsertRaw(const Signal& signal, std::int64_t raw, std::span<std::uint8_t> data) noexcept {
  const auto bits = static_cast<std::uint64_t>(raw);
  ForEachChunk(signal, [&](const BitChunk& chunk) {
    const auto shift = static_cast<unsigned>(chunk.low_bit);
    const auto piece = static_cast<unsigned>(bits >> static_cast<unsigned>(chunk.raw_bit)) & chunk.Mask();
    const unsigned kept = unsigned{data[chunk.byte]} & ~(chunk.Mask() << shift);
    data[chunk.byte] = static_cast<std::uint8_t>(kept | (piece << shift));
  });
}

std::optional<std::int64_t> RawInField(const Signal& signal, std::int64_t number) noexcept {
  if (signal.length_bits == 64) return number;
  std::array<std::uint8_t, 64> data{};
  InsertRaw(signal, number, data);
  const std::int64_t raw = ExtractRaw(signal, data);
  const std::int64_t values = std::int64_t{1} << static_cast<unsigned>(signal.length_bits);
  const bool fits = number >= -values / 2 && number < values;
  return fits && (raw - number) % values == 0 ? std::optional(raw) : std::nullopt;
}

std::string NameOfRaw(const Signal& signal, std::int64_t raw) {
  if (const auto found = signal.value_names.find(raw); found != signal.value_names.end())
    return found->second;
  for (const auto& [number, name] : signal.value_names) {
    if (RawInField(signal, number) == raw) return name;
  }
  return {};
}

bool Carries(const Message& message, const Signal& signal, std::span<const std::uint8_t> data) noexcept {
  if (signal.multiplexing == Multiplexing::kAlways || signal.multiplexing == Multiplexing::kSelector)
    return true;
  const Signal* selector = message.Selector();
  return selector != nullptr && ExtractRaw(*selector, data) == signal.selected_by;
}

double Decode(const Signal& signal, std::span<const std::uint8_t> data) noexcept {
  return RawNumber(signal, ExtractRaw(signal, data)) * signal.factor + signal.offset;
}

bool IsInStatedRange(const Signal& signal, std::int64_t raw) noexcept {
  if (!(signal.minimum < signal.maximum)) return true;
  const double number = RawNumber(signal, raw);
  if (signal.type == ValueType::kInteger) {
    const RawLimits limits = StatedRange(signal);
    return number >= limits.low && number <= limits.high;
  }
  const double value = number * signal.factor + signal.offset;
  return value >= signal.minimum - RoundingOf(signal, signal.minimum) &&
         value <= signal.maximum + RoundingOf(signal, signal.maximum);
}

double RoundingOf(const Signal& signal, double physical) noexcept {
  const double decoding = (std::fabs(physical) + 2.0 * std::fabs(signal.offset)) * 0x1p-51;
  const double scaled = std::fabs(physical - signal.offset);
  switch (signal.type) {
    case ValueType::kFloat32:
      return scaled * 0x1p-22 + decoding;
    case ValueType::kFloat64:
      return scaled * 0x1p-51 + decoding;
    case ValueType::kInteger:
      break;
  }
  return 0.5 * std::fabs(signal.factor) + decoding;
}

bool IsExact(const Signal& signal, std::int64_t raw) noexcept {
  if (signal.type != ValueType::kInteger || raw == 0) return true;
  const auto bits = static_cast<std::uint64_t>(raw);
  const std::uint64_t magnitude = signal.is_signed && raw < 0 ? ~bits + 1 : bits;
  const int significant = 64 - std::countl_zero(magnitude) - std::countr_zero(magnitude);
  return significant <= std::numeric_limits<double>::digits;
}

bool Encode(const Signal& signal, double physical, std::span<std::uint8_t> data) noexcept {
  return signal.type == ValueType::kInteger ? EncodeInteger(signal, physical, data)
                                            : EncodeFloat(signal, physical, data);
}

}  // namespace servohil::can
