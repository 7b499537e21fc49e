#pragma once
/// Faults over CAN: FAULT_Request in, FAULT_Response out (PROTOCOL.md).
///
///   [can_rx] Take(request) ─ Request ▶ ring ▶ [sim] ─ Answer ▶ ring ─┐
///                          └ what is wrong with it ▶ ring ───────────┴▶ [can_tx] response

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "can/bus.hpp"
#include "can/dbc/dbc.hpp"
#include "can/frame.hpp"
#include "fault/catalogue.hpp"
#include "rt/ring.hpp"
#include "simulation/request.hpp"

namespace servohil::emulator {

/// Raw values of FAULT_Request.Action.
enum class FaultAction : std::uint8_t { kSet = 0, kStart = 1, kClear = 2, kClearAll = 3 };
/// Raw values of FAULT_Request.Field: what kSet sets. Below 3: the fault's own parameters, in their order.
enum class FaultField : std::uint8_t { kRampS = 3, kForS = 4, kSeed = 5 };
/// Raw values of FAULT_Response.Result and .Reason.
enum class FaultResult : std::uint8_t { kApplied = 0, kRejected = 1, kUnsupported = 2, kSet = 3 };
enum class FaultReason : std::uint8_t {
  kNone = 0,
  kUnknownFault = 1,
  kUnknownField = 2,  ///< or action
  kOutOfRange = 3,
  kNotArmed = 4,
  kNoRoom = 5,  ///< as many faults as there can be at once
  kNotInjected = 6,
  kFrozen = 7,
  kUnknownTarget = 8,
  kBusy = 9,           ///< too many requests wait
  kNotInThisRun = 10,  ///< UNSUPPORTED: `servohil fault inject` tells why
};

class FaultPort {
 public:
  struct Rights {
    fault::Surroundings surroundings;
    bool armed = false;          ///< at the start
    std::size_t messages = 0;    ///< that are published: targets of faults of the bus
    std::size_t quantities = 0;  ///< targets of faults of sensors
  };

  /// With FAULT_Request and FAULT_Response of `databases`.
  /// @throws UsageError where one of the messages or a signal of it is missing
  FaultPort(const can::Databases& databases, const Rights& rights);

  /// What must be received for it. @throws UsageError where there is no FAULT_Request
  static can::WantedId RequestId(const can::Databases& databases);

  /// Any thread: whether faults may be started from now on.
  void Arm(bool armed) noexcept { armed_.store(armed, std::memory_order_relaxed); }

  /// Receiver thread: what the frame asks of the simulation; nothing: it is none of ours, or it is answered
  /// already. Real-time safe.
  std::optional<simulation::Request> Take(const can::Frame& frame) noexcept;
  /// Receiver thread: the simulation takes no more. Real-time safe.
  void TellBusy(const simulation::Request& request) noexcept;

  /// Sender thread: a response that waits, oldest first. Real-time safe.
  bool TryPopResponse(can::Frame& frame) noexcept { return responses_.TryPop(frame); }
  /// Sender thread: the simulation's answer as a frame. Real-time safe.
  can::Frame ResponseTo(const simulation::Answer& answer) const noexcept;

 private:
  /// What a response repeats of its request.
  struct Asked {
    std::uint8_t action = 0;
    std::uint8_t number = 0;
    std::uint8_t fault = 0;
    std::uint64_t Packed() const noexcept {
      return std::uint64_t{1} << 32U | std::uint64_t{action} << 16U | std::uint64_t{number} << 8U | fault;
    }
    static Asked From(std::uint64_t packed) noexcept;
  };
  struct Signals {
    const can::Signal* action;
    const can::Signal* number;
    const can::Signal* fault;
    const can::Signal* field;
    const can::Signal* target;
    const can::Signal* value;
  };
  struct ResponseSignals {
    const can::Signal* action;
    const can::Signal* number;
    const can::Signal* fault;
    const can::Signal* result;
    const can::Signal* reason;
    const can::Signal* tick;
  };

  std::optional<simulation::Request> Start(const Asked& asked, const fault::Spec& spec,
                                           std::uint8_t target) noexcept;
  void Set(const Asked& asked, const fault::Spec& spec, std::uint8_t field, double value) noexcept;
  bool IsTarget(const fault::Spec& spec, std::uint8_t target) const noexcept;
  void Reply(const Asked& asked, FaultResult result, FaultReason reason) noexcept;
  can::Frame Response(const Asked& asked, FaultResult result, FaultReason reason,
                      std::uint64_t tick) const noexcept;

  const can::Message request_;
  const can::Message response_;
  const Signals in_;
  const ResponseSignals out_;
  const Rights rights_;
  std::atomic<bool> armed_;
  std::array<std::optional<fault::Injection>, 256> set_{};  ///< by number: what was set since the last start
  rt::Ring<can::Frame, 64> responses_;
};

}  // namespace servohil::emulator
