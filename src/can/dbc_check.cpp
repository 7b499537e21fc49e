#include "dbc_check.hpp"

#include <cstddef>
#include <string>
#include <vector>

#include "bit_chunks.hpp"
#include "servohil/error.hpp"

namespace servohil::can {
namespace {

constexpr std::uint32_t kLargestStandardId = 0x7FF;        // 11 bits
constexpr std::uint32_t kLargestExtendedId = 0x1FFF'FFFF;  // 29 bits

[[noreturn]] void Fail(const Database& database, int line, const std::string& what) {
  throw UsageError(database.file + ":" + std::to_string(line) + ": " + what);
}

void CheckIdentity(const Database& database, const Message& message) {
  const std::string called = "message '" + message.name + "'";
  const std::uint32_t largest = message.extended ? kLargestExtendedId : kLargestStandardId;
  if (message.id > largest) {
    Fail(database, message.line,
         called + " has the id " + std::to_string(message.id) + ", expected at most " +
             std::to_string(largest) +
             (message.extended ? "" : " (29-bit ids have bit 31 set: add 2147483648)"));
  }
  for (const Message& other : database.messages) {
    if (other.name == message.name) {
      Fail(database, message.line, called + " is there twice, first in line " + std::to_string(other.line));
    }
    if (other.id == message.id && other.extended == message.extended) {
      Fail(database, message.line,
           called + " has the id " + std::to_string(message.id) + " of '" + other.name + "' in line " +
               std::to_string(other.line));
    }
  }
}

void CheckPlaces(const Database& database, const Message& message) {
  const auto size = static_cast<std::size_t>(message.size_bytes);
  std::vector<const Signal*> owner(size * 8, nullptr);
  for (const Signal& signal : message.signals) {
    const std::string called = "signal '" + signal.name + "' (" + std::to_string(signal.start_bit) + "|" +
                               std::to_string(signal.length_bits) + "@" +
                               (signal.little_endian ? "1)" : "0)");
    ForEachChunk(signal, [&](const BitChunk& chunk) {
      if (chunk.byte >= size) {
        Fail(database, signal.line,
             called + " reaches beyond the " + std::to_string(size) + " bytes of message '" + message.name +
                 "'");
      }
      if (signal.multiplexed) return;
      for (int bit = 0; bit < chunk.count; ++bit) {
        const Signal*& here = owner[chunk.byte * 8 + static_cast<std::size_t>(chunk.low_bit + bit)];
        if (here != nullptr) {
          Fail(database, signal.line,
               called + " overlaps signal '" + here->name + "' of line " + std::to_string(here->line) +
                   " in byte " + std::to_string(chunk.byte));
        }
        here = &signal;
      }
    });
  }
}

void CheckNames(const Database& database, const Message& message) {
  for (const Signal& signal : message.signals) {
    const Signal* first = message.FindSignal(signal.name);
    if (first != &signal) {
      Fail(database, signal.line,
           "signal '" + signal.name + "' is there twice, first in line " + std::to_string(first->line));
    }
  }
}

}  // namespace

void CheckNewMessage(const Database& database, const Message& message) {
  CheckIdentity(database, message);
  CheckNames(database, message);
  CheckPlaces(database, message);
}

}  // namespace servohil::can
