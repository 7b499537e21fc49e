#include "can/dbc/dbc_check.hpp"

#include <cstddef>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "can/dbc/bit_chunks.hpp"

namespace servohil::can {
namespace {

constexpr int kLargestFrame = 64;                          // bytes, CAN FD
constexpr std::uint32_t kLargestStandardId = 0x7FF;        // 11 bits
constexpr std::uint32_t kLargestExtendedId = 0x1FFF'FFFF;  // 29 bits

[[noreturn]] void Fail(const Database& database, int line, const std::string& what) {
  throw base::UsageError(database.file + ":" + std::to_string(line) + ": " + what);
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

/// Whether a frame can have both. With extended multiplexing that is not decided here.
bool Together(const Signal& a, const Signal& b) {
  if (a.multiplexing == Multiplexing::kExtended || b.multiplexing == Multiplexing::kExtended) return false;
  const bool both_selected =
      a.multiplexing == Multiplexing::kSelected && b.multiplexing == Multiplexing::kSelected;
  return !both_selected || a.selected_by == b.selected_by;
}

std::string Place(const Signal& signal) {
  return "signal '" + signal.name + "' (" + std::to_string(signal.start_bit) + "|" +
         std::to_string(signal.length_bits) + "@" + (signal.little_endian ? "1)" : "0)");
}

void CheckPlaces(const Database& database, const Message& message) {
  const auto size = static_cast<std::size_t>(message.size_bytes);
  std::vector<std::vector<const Signal*>> owners(size * 8);
  for (const Signal& signal : message.signals) {
    ForEachChunk(signal, [&](const BitChunk& chunk) {
      if (chunk.byte >= size) {
        Fail(database, signal.line,
             Place(signal) + " reaches beyond the " + std::to_string(size) + " bytes of message '" +
                 message.name + "'");
      }
      for (int bit = 0; bit < chunk.count; ++bit) {
        auto& here = owners[chunk.byte * 8 + static_cast<std::size_t>(chunk.low_bit + bit)];
        for (const Signal* other : here) {
          if (!Together(signal, *other)) continue;
          Fail(database, signal.line,
               Place(signal) + " overlaps signal '" + other->name + "' of line " +
                   std::to_string(other->line) + " in byte " + std::to_string(chunk.byte));
        }
        here.push_back(&signal);
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

void CheckUsable(const Database& database, const Message& message) {
  const auto refuse = [&](int line, const std::string& what) {
    Fail(database, line, "message '" + message.name + "' " + what);
  };
  if (message.size_bytes > kLargestFrame) {
    refuse(message.line, "has " + std::to_string(message.size_bytes) + " bytes; a CAN FD frame holds 64");
  }
  for (const Signal& signal : message.signals) {
    const Signal* selector = message.Selector();
    switch (signal.multiplexing) {
      case Multiplexing::kAlways:
        break;
      case Multiplexing::kExtended:
        refuse(signal.line, "has the signal '" + signal.name +
                                "' with extended multiplexing (m0M, or several values in " +
                                "SG_MUL_VAL_): only one multiplexer M and its m0, m1, ... are supported");
        break;
      case Multiplexing::kSelected:
        if (selector == nullptr) {
          refuse(signal.line, "has the multiplexed signal '" + signal.name + "', but no multiplexer (M)");
        }
        break;
      case Multiplexing::kSelector:
        if (selector != &signal) {
          refuse(signal.line, "has two multiplexers (M): '" + selector->name + "' and '" + signal.name + "'");
        }
        break;
    }
    const int bits = signal.type == ValueType::kFloat64 ? 64 : 32;
    if (signal.type != ValueType::kInteger && signal.length_bits != bits) {
      refuse(signal.line, "has the floating-point signal '" + signal.name + "' (SIG_VALTYPE_ " +
                              (bits == 64 ? "2" : "1") + ") of " + std::to_string(signal.length_bits) +
                              " bits, expected " + std::to_string(bits));
    }
  }
}

}  // namespace servohil::can
