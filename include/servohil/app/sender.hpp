#pragma once
/// Frames out.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "servohil/app/contract.hpp"
#include "servohil/app/delayed.hpp"
#include "servohil/app/recording/recorder.hpp"
#include "servohil/app/simulation_task.hpp"
#include "servohil/can/network.hpp"
#include "servohil/rt/latency_histogram.hpp"

namespace servohil::app {

/// Totals since the start.
struct SendCounters {
  std::atomic<std::uint64_t> published{0};
  std::atomic<std::uint64_t> not_sent{0};    ///< refused by a full queue or a bus that is down
  std::atomic<std::uint64_t> superseded{0};  ///< not sent because a newer state was already there
  std::atomic<std::uint64_t> faulted{0};     ///< kept from the bus by an injected fault
  std::atomic<std::uint64_t> babbled{0};     ///< sent by faults alone: nonsense and error frames
};

/// One thread.
class Sender {
 public:
  /// All must outlive it; `recorder` may be null.
  Sender(const Contract& contract, SimulationTask& task, can::Network& network, Recorder* recorder)
      : contract_(contract),
        task_(task),
        network_(network),
        recorder_(recorder),
        waiting_(contract.MessageCount()),
        reflect_command_(contract.MessagesCarrying("x3_in")),
        tell_lateness_(contract.MessagesCarrying("recent_lateness_ms")),
        tell_mode_(contract.MessagesCarrying("mode")) {}

  /// Real time: of several states that wait, only the newest of each message is sent, and no two closer than
  /// half its cycle: after a delay the bus gets the present, not a burst of the past.
  void SendDue() noexcept { SendWaiting(false); }
  /// The same at the end: whatever waits, at once.
  void SendRest() noexcept { SendWaiting(true); }

  /// Lockstep, by the thread that runs the ticks: every message, with the state now; a full queue is waited
  /// for until `stop`.
  void SendAll(const std::atomic<bool>& stop) noexcept;

  /// Every message that carries the mode, which is STOPPED.
  void SendStopped() noexcept;

  /// Any thread.
  const SendCounters& Counters() const noexcept { return counters_; }
  /// From the arrival of a command's frame to the first frame with a position that reflects it. Any thread.
  const rt::LatencyHistogram& ArrivalToFrame() const noexcept { return arrival_to_frame_; }

 private:
  struct Outgoing {
    can::Frame frame;
    std::size_t message = 0;
    std::uint64_t tick = 0;       ///< whose state it carries
    std::int64_t arrival_ns = 0;  ///< of the command that this state reflects
  };

  void SendWaiting(bool at_once) noexcept;
  void TakePublication(const Publication& publication) noexcept;
  /// What faults make of it.
  void Send(std::size_t message, const Publication& publication) noexcept;
  void Transmit(const Outgoing& outgoing) noexcept;
  can::SendResult Try(const can::Frame& frame) noexcept;
  void Account(const Outgoing& outgoing, can::SendResult result) noexcept;
  /// What faults send on their own, and what they have held back.
  void FollowFaults() noexcept;
  void SendNonsense(const fault::Line& line, std::uint64_t ticks) noexcept;

  const Contract& contract_;
  SimulationTask& task_;
  can::Network& network_;
  Recorder* recorder_;
  /// Newest state of each message that is due, and when it may go.
  struct Waiting {
    bool due = false;
    std::int64_t not_before_ns = 0;
    Publication publication;
    std::optional<Outgoing> overtaken;  ///< to be sent after the next one
  };
  std::vector<Waiting> waiting_;      ///< of each message
  const MessageSet reflect_command_;  ///< carry the position
  const MessageSet tell_lateness_;
  const MessageSet tell_mode_;
  std::int64_t last_arrival_ns_ = 0;  ///< of the newest command that was reflected
  rt::LatencyHistogram arrival_to_frame_;
  SendCounters counters_;
  const std::atomic<bool>* patient_until_ = nullptr;  ///< a full queue is waited for

  static constexpr std::size_t kMostDelayed = 1'024;
  fault::Schedule faults_;
  std::uint64_t followed_tick_ = 0;
  Delayed<Outgoing> delayed_{kMostDelayed};
  double babble_owed_ = 0.0;
  double errors_owed_ = 0.0;
};

}  // namespace servohil::app
