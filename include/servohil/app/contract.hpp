#pragma once
/// The DBC file bound to the emulator's quantities: which frame carries the command, and what goes into which
/// signal of the published ones. No id, scale or offset is compiled in.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "servohil/app/configuration.hpp"
#include "servohil/app/publication.hpp"
#include "servohil/app/quantity.hpp"
#include "servohil/app/telemetry.hpp"
#include "servohil/can/dbc.hpp"
#include "servohil/can/frame.hpp"

namespace servohil::app {

/// Why a frame is not a command.
enum class CommandRejection : std::uint8_t {
  kUnknownId,   ///< somebody else's frame: counted, never an error
  kMalformed,   ///< ours, but too short or a remote frame
  kOutOfRange,  ///< P1 outside the DBC's range, or not a number
};

class Contract {
 public:
  /// @throws UsageError naming file, line, and what is missing or of another unit
  Contract(can::Database database, const PublishSettings& publish);

  /// Identifier of the command frame.
  std::uint32_t CommandId() const noexcept { return command_->id; }
  bool CommandIsExtended() const noexcept { return command_->extended; }
  /// Command in `frame`; else `rejection` tells why not.
  std::optional<Command> DecodeCommand(const can::Frame& frame, CommandRejection& rejection) const noexcept;

  /// Frame of one published message. Values that its signals cannot hold saturate; what is not available has
  /// all bits of its field 1.
  can::Frame Encode(std::size_t message, const Telemetry& telemetry,
                    const Measured& measured = {}) const noexcept;

  /// How many messages are published, at most kMostMessages: numbers 0 to MessageCount() - 1.
  std::size_t MessageCount() const noexcept { return outgoing_.size(); }
  /// Layout of one published message.
  const can::Message& MessageOf(std::size_t message) const noexcept { return *outgoing_[message].message; }
  /// Cycle time of one published message in ticks.
  std::uint64_t CycleTicks(std::size_t message) const noexcept;
  /// Those of all.
  std::array<std::uint64_t, kMostMessages> Cycles() const noexcept;
  /// The messages that carry the quantity of this name. @pre there is one
  MessageSet MessagesCarrying(std::string_view quantity) const noexcept;

  /// One line per message that this run sends or receives, with its share of the bus.
  struct Load {
    std::string message;
    int cycle_ms = 0;
    double bits_per_s = 0.0;  ///< at worst-case bit stuffing
  };
  std::vector<Load> BusLoad(int command_cycle_ms) const;

 private:
  struct Field {
    const can::Signal* signal;
    const Quantity* quantity;
  };
  struct Outgoing {
    const can::Message* message = nullptr;
    std::vector<Field> fields;
    int cycle_ms = 0;
  };

  void Publish(const can::Message& message, int cycle_ms, std::span<const char* const> quantities);

  can::Database database_;
  const can::Message* command_;
  const can::Signal* p1_demand_;
  std::vector<Outgoing> outgoing_;
};

/// Longest time on the bus, in bits, of a classical frame with `size_bytes` of data: worst-case stuffing and
/// interframe space included. Davis, Burns, Bril, Lukkien, "Controller Area Network schedulability analysis",
/// Real-Time Systems 35 (2007), eq. (1): g + 8s + 13 + floor((g + 8s - 1)/4), g = 34 (standard) or 54
/// (extended).
int WorstCaseFrameBits(int size_bytes, bool extended) noexcept;

}  // namespace servohil::app
