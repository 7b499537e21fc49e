#pragma once
/// Where the bits of a signal lie: the same walk for reading, writing and the overlap check.

#include <algorithm>
#include <cstddef>

#include "can/dbc/dbc.hpp"

namespace servohil::can {

/// Bits [low_bit, low_bit + count) of data byte `byte` hold bits [raw_bit, raw_bit + count) of the raw value.
struct BitChunk {
  std::size_t byte;
  int low_bit;
  int count;
  int raw_bit;

  unsigned Mask() const noexcept { return (1U << static_cast<unsigned>(count)) - 1U; }
};

/// Calls visit(BitChunk) for each byte that the signal touches.
///   Intel:    start_bit is the LSB; the value grows towards higher bits, then the next byte.
///   Motorola: start_bit is the MSB; the value shrinks towards bit 0, then goes on at bit 7 of the next byte.
template <typename Visit>
void ForEachChunk(const Signal& signal, Visit visit) {
  int bit = signal.start_bit;
  for (int done = 0; done < signal.length_bits;) {
    const int in_byte = bit % 8;
    const int left = signal.length_bits - done;
    const auto byte = static_cast<std::size_t>(bit / 8);
    if (signal.little_endian) {
      const int count = std::min(8 - in_byte, left);
      visit(BitChunk{byte, in_byte, count, done});
      bit += count;
      done += count;
    } else {
      const int count = std::min(in_byte + 1, left);
      visit(BitChunk{byte, in_byte + 1 - count, count, left - count});
      bit = (bit / 8 + 1) * 8 + 7;
      done += count;
    }
  }
}

}  // namespace servohil::can
