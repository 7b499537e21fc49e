#pragma once
/// Frames out.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "can/network.hpp"
#include "emulator/delayed.hpp"
#include "emulator/simulation_task.hpp"
#include "recording/recorder.hpp"
#include "rt/latency_histogram.hpp"
#include "rt/mailbox.hpp"
#include "signal_map/signal_map.hpp"

namespace servohil::emulator {

/// Totals since the start.
struct SendCounters {
  std::atomic<std::uint64_t> published{0};
  std::atomic<std::uint64_t> not_sent{0};    ///< refused by a full queue or a bus that is down
  std::atomic<std::uint64_t> superseded{0};  ///< not sent because a newer state was already there
  std::atomic<std::uint64_t> faulted{0};     ///< kept from the bus by an injected fault
  std::atomic<std::uint64_t> babbled{0};     ///< sent by faults alone: nonsense and error frames
  std::atomic<std::uint64_t> unchanged{0};   ///< not sent because the message is sent on change
  /// Of each message: frames in which a measured value was more than its signal holds, and those signals.
  std::array<std::atomic<std::uint64_t>, simulation::kMaxMessages> saturated{};
  std::array<std::atomic<signal_map::FieldSet>, simulation::kMaxMessages> saturated_fields{};
};

/// One thread.
class Sender {
 public:
  /// All must outlive it; `recorder` may be null.
  Sender(const signal_map::SignalMap& signal_map, SimulationTask& task, can::Network& network,
         recording::Recorder* recorder)
      : signal_map_(signal_map),
        task_(task),
        network_(network),
        recorder_(recorder),
        waiting_(signal_map.MessageCount()),
        written_(signal_map.MessageCount()),
        reflect_command_(signal_map.MessagesCarrying("x3_in")),
        tell_lateness_(signal_map.MessagesCarrying("recent_lateness_ms")),
        tell_mode_(signal_map.MessagesCarrying("mode")),
        tell_bus_(signal_map.MessagesCarrying("bus_state")) {
    for (std::size_t i = 0; i < written_.size(); ++i)
      written_[i].newest.resize(signal_map.OutgoingMessages()[i].pages.size());
  }

  /// Real time: of several states that wait, only the newest of each message is sent, and no two closer than
  /// half its cycle: after a delay the bus gets the present, not a burst of the past.
  void SendDue() noexcept { SendWaiting(false); }
  /// The sender's thread: all that was due up to this tick has been sent.
  bool IsDoneUpTo(std::uint64_t tick) const noexcept {
    return nothing_waits_ && newest_.run_state.sample.tick >= tick;
  }
  /// The same at the end: whatever waits, at once.
  void SendRest() noexcept { SendWaiting(true); }

  /// Lockstep, by the thread that runs the ticks: every message in this order, with the state now; a full
  /// queue is waited for until `stop`.
  void SendAll(const std::atomic<bool>& stop, std::span<const std::size_t> order) noexcept;

  /// Every message that carries the mode, which is STOPPED.
  void SendStopped() noexcept;

  /// Any one thread: how the bus is. Messages that tell its state are sent at each change of it.
  void PutBusCondition(const can::BusCondition& condition) noexcept { conditions_.Put(condition); }

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
  void TakePublication(const simulation::Publication& publication) noexcept;
  void TakeBusCondition() noexcept;
  /// The message's next frame; nothing: it is sent on change, and nothing has changed.
  std::optional<can::Frame> Next(std::size_t message, const simulation::Publication& publication) noexcept;
  /// What faults make of it.
  void Send(std::size_t message, simulation::Publication& publication) noexcept;
  void Transmit(const Outgoing& outgoing) noexcept;
  can::SendResult Try(const can::Frame& frame) noexcept;
  void Account(const Outgoing& outgoing, can::SendResult result) noexcept;
  /// What faults send on their own, and what they have held back.
  void FollowFaults() noexcept;
  void SendBabble(const fault::Line& line, std::uint64_t ticks) noexcept;

  const signal_map::SignalMap& signal_map_;
  SimulationTask& task_;
  can::Network& network_;
  recording::Recorder* recorder_;
  /// Newest state of each message that is due, and when it may go.
  struct Waiting {
    bool due = false;
    std::int64_t not_before_ns = 0;
    simulation::Publication publication;
    std::optional<Outgoing> overtaken;  ///< to be sent after the next one
  };
  /// What has been written of a message.
  struct Written {
    unsigned counter = ~0U;  ///< of its protection: of the frame before; the first has 0
    std::uint64_t turn = 0;  ///< frames that were due: says which page comes
    std::vector<std::optional<can::Frame>> newest;  ///< of each page
  };
  std::vector<Waiting> waiting_;                  ///< of each message
  std::vector<Written> written_;                  ///< of each message
  const simulation::MessageSet reflect_command_;  ///< carry the position
  const simulation::MessageSet tell_lateness_;
  const simulation::MessageSet tell_mode_;
  const simulation::MessageSet tell_bus_;
  rt::Mailbox<can::BusCondition> conditions_;
  can::BusCondition bus_;
  simulation::Publication newest_;
  bool nothing_waits_ = true;         ///< after the last look
  std::int64_t last_arrival_ns_ = 0;  ///< of the newest command that was reflected
  rt::LatencyHistogram arrival_to_frame_;
  SendCounters counters_;
  const std::atomic<bool>* patient_until_ = nullptr;  ///< a full queue is waited for

  static constexpr std::size_t kMaxDelayed = 1'024;
  fault::Schedule faults_;
  std::uint64_t followed_tick_ = 0;
  Delayed<Outgoing> delayed_{kMaxDelayed};
  double babble_owed_ = 0.0;
  double errors_owed_ = 0.0;
};

}  // namespace servohil::emulator
