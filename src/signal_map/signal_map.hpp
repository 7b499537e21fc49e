#pragma once
/// The DBC files bound to the emulator's quantities: which frames carry the command, and what goes into which
/// signal of the published ones. No id, scale or offset is compiled in.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "can/dbc/dbc.hpp"
#include "can/dbc/id_pattern.hpp"
#include "can/e2e/e2e.hpp"
#include "can/frame.hpp"
#include "configuration/configuration.hpp"
#include "signal_map/unit.hpp"
#include "simulation/publication.hpp"
#include "simulation/quantity.hpp"
#include "simulation/run_state.hpp"

namespace servohil::signal_map {

/// Why a frame says nothing.
enum class CommandRejection : std::uint8_t {
  kNone,
  kUnknownId,     ///< somebody else's frame, or a multiplexed one with other signals: counted, never an error
  kMalformed,     ///< ours, but too short or a remote frame
  kOutOfRange,    ///< P1 outside the DBC's range, not a number, or a value that J1939 reserves
  kNotAvailable,  ///< P1 is "not available" by J1939
  kErrorIndicator,  ///< P1 is the error indicator of J1939
};

/// What one frame of the governor says; empty: it does not carry that.
struct Demand {
  std::optional<double> p1_psi;
  double p1_rounding_psi = 0.0;  ///< how far P1 may be from what was meant: the frame's resolution
  std::optional<bool> enabled;
  std::optional<bool> trip;
};

/// `command` with what `demand` says; the rest stays.
void Merge(const Demand& demand, simulation::Command& command) noexcept;

/// A signal that is true or false.
struct Condition {
  const can::Signal* signal = nullptr;
  std::vector<std::int64_t> values;  ///< raw values for true; none: any but 0
};

/// A message of the governor's that the emulator reads.
struct ReceivedMessage {
  const can::Database* database = nullptr;
  const can::Message* message = nullptr;
  can::IdPattern pattern;
  int cycle_ms = 0;        ///< expected
  std::string cycle_from;  ///< the key, or where in a DBC file: "governor.dbc:12, GenMsgCycleTime"
  std::string place;       ///< where the configuration names it
  const can::Signal* p1 = nullptr;
  Linear p1_to_psi;
  std::optional<Condition> enable;
  std::optional<Condition> trip;
  std::optional<can::E2eLayout> protection;

  /// Raw values have the meaning that J1939 gives them.
  bool IsJ1939() const noexcept { return message->j1939 || pattern.pgn; }
};

/// A signal that carries a quantity.
struct Field {
  const can::Signal* signal = nullptr;
  const simulation::Quantity* quantity = nullptr;
  Linear convert;         ///< from the quantity to the signal's physical value
  int number = 0;         ///< among all fields of the message, 0 to kMaxFields - 1
  bool measured = false;  ///< a position, velocity or pressure: saturation is told
};

/// One frame's content. A multiplexed message has several: one for each value of its multiplexer.
struct Page {
  std::optional<std::int64_t> selected_by;
  std::array<std::uint8_t, 64>
      constants{};  ///< what is in no field: start values, constants, the multiplexer
  std::vector<Field> fields;
};

/// A message that the emulator publishes.
struct PublishedMessage {
  const can::Database* database = nullptr;
  const can::Message* message = nullptr;
  int cycle_ms = 0;
  bool on_change = false;
  std::vector<Page> pages;  ///< sent in turn, one each cycle
  std::optional<can::E2eLayout> protection;
  std::string place;  ///< where the configuration names it; empty: nowhere
};

/// Some of a message's fields, by number.
using FieldSet = std::uint64_t;
inline constexpr int kMaxFields = 64;

class SignalMap {
 public:
  /// @throws UsageError naming file and line, of the DBC and of the configuration, and what would be right
  SignalMap(can::Databases databases, const configuration::Configuration& configuration);
  /// The same with the DBC files that the configuration names.
  explicit SignalMap(const configuration::Configuration& configuration);

  /// What the governor sends, the message with P1 first.
  std::span<const ReceivedMessage> IncomingMessages() const noexcept { return incoming_; }
  /// That message.
  const can::Message& CommandMessage() const noexcept { return *incoming_.front().message; }
  /// Expected time between two commands [ms].
  int CommandCycleMs() const noexcept { return incoming_.front().cycle_ms; }
  /// Where configuration and DBC file differ in it, in words; empty: they do not.
  const std::string& CycleMismatch() const noexcept { return cycle_mismatch_; }
  /// Whether the frame has that message's identifier. Real-time safe.
  bool IsCommand(const can::Frame& frame) const noexcept {
    return !frame.error && incoming_.front().pattern.Matches(frame.id, frame.extended);
  }
  /// What the frame is to be read as; null: none of the governor's messages. Real-time safe.
  const ReceivedMessage* FindIncoming(const can::Frame& frame) const noexcept;
  /// Whether the governor has an enable signal.
  bool HasEnable() const noexcept;
  /// The DBC files.
  const can::Databases& Databases() const noexcept { return databases_; }
  /// Identifiers to receive.
  std::vector<can::WantedId> Wanted() const;
  /// What `frame` says. `rejection` tells why it says nothing, or why the P1 in it does not count.
  /// Real-time safe.
  std::optional<Demand> Decode(const can::Frame& frame, CommandRejection& rejection) const noexcept;

  /// Frame of one published message; `turn` counts its frames: multiplexed ones send their pages in turn.
  /// Values that its signals cannot hold saturate; `saturated` tells which of the measured ones did
  /// (positions, velocities, pressures; counters and times do so by design). What is not available has all
  /// bits of its field 1. Real-time safe.
  can::Frame Encode(std::size_t message, const simulation::RunState& run_state,
                    const simulation::Measured& measured = {}, std::uint64_t turn = 0,
                    FieldSet* saturated = nullptr) const noexcept;
  /// Counter and checksum of a message that has them, as the last step before its frame is sent. Real-time
  /// safe. @param counter  goes round by itself @param wrong_checksum  all bits of it inverted
  void Protect(std::size_t message, unsigned counter, bool wrong_checksum, can::Frame& frame) const noexcept;
  /// Whether the protection of any published message has this.
  bool AnyPublished(bool (*has)(const can::E2eLayout&)) const noexcept;

  /// What is published, at most kMaxMessages, by number.
  std::span<const PublishedMessage> OutgoingMessages() const noexcept { return outgoing_; }
  std::size_t MessageCount() const noexcept { return outgoing_.size(); }
  /// Layout of one published message.
  const can::Message& MessageOf(std::size_t message) const noexcept { return *outgoing_[message].message; }
  /// Cycle time of one published message in ticks.
  std::uint64_t CycleTicks(std::size_t message) const noexcept;
  /// Those of all.
  std::array<std::uint64_t, simulation::kMaxMessages> Cycles() const noexcept;
  /// Whether any message of the run is CAN FD.
  bool UsesFd() const noexcept;
  /// The messages that carry the quantity of this name. @pre there is one
  simulation::MessageSet MessagesCarrying(std::string_view quantity) const noexcept;

  /// One line per message that this run sends or receives, with its share of the bus.
  struct Load {
    std::string message;
    int cycle_ms = 0;
    double bits_per_s = 0.0;  ///< at worst-case bit stuffing, in bits at the nominal rate
  };
  std::vector<Load> BusLoad() const;

 private:
  can::Databases databases_;
  std::vector<ReceivedMessage> incoming_;
  std::vector<PublishedMessage> outgoing_;
  std::string cycle_mismatch_;
  double data_rate_ratio_ = 1.0;  ///< nominal to data bit rate of CAN FD
};

}  // namespace servohil::signal_map
