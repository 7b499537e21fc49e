#include "can/slcan/slcan_adapter.hpp"

#include <chrono>

#include "can/realtime_clock.hpp"
#include "can/slcan/slcan_codec.hpp"

namespace servohil::can {
namespace {

using Clock = std::chrono::steady_clock;

/// Time stamps count milliseconds and begin anew each minute (LAWICEL CAN232).
std::uint16_t TimestampMs(Clock::time_point now) noexcept {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch());
  return static_cast<std::uint16_t>(ms.count() % 60'000);
}

}  // namespace

SlcanAdapter::SlcanAdapter(const std::string& link)
    : link_(link, pty_.SlavePath()), path_(link.empty() ? pty_.SlavePath() : link), name_("slcan:" + path_) {}

SlcanAdapter::~SlcanAdapter() {
  Drain();
}

// Closing the master throws away what the client has not read yet: the last status among it.
std::uint64_t SlcanAdapter::Drain() noexcept {
  const std::lock_guard lock(mutex_);
  if (!connected_ || !session_.IsOpen()) return 0;
  const std::uint64_t lost = outbox_.Drain();
  Counters::Add(counters_.dropped_queue_full, lost);
  return lost;
}

std::string SlcanAdapter::ConnectHint() const {
  return R"(python-can: can.Bus(interface="slcan", channel=")" + path_ + R"(", bitrate=500000))";
}

std::string SlcanAdapter::State() const {
  if (!connected_) return "no client";
  const std::lock_guard lock(mutex_);
  if (!session_.IsOpen()) return "client connected, channel closed";
  return session_.IsListenOnly() ? "client connected, listen only" : "client connected, channel open";
}

void SlcanAdapter::Disconnect() {
  if (!connected_.exchange(false)) return;
  assembler_.Clear();
  const std::lock_guard lock(mutex_);
  session_.Reset();
  outbox_.Reset();
  pty_.SetRaw();
}

std::optional<Frame> SlcanAdapter::HandleLine(const slcan::Line& line) {
  const std::lock_guard lock(mutex_);
  const bool was_open = session_.IsOpen();
  const slcan::Answer answer = line.kind == slcan::LineKind::kText ? session_.Handle(line.text)
                                                                   : slcan::Answer{"\a", std::nullopt, true};
  std::uint64_t lost = 0;
  if (was_open && !session_.IsOpen()) lost += outbox_.TakeBack();
  lost += outbox_.Write(answer.text, Clock::now()).lost_frames;
  if (lost > 0) session_.SetOverrun();
  Counters::Add(counters_.dropped_queue_full, lost);
  Counters::Add(counters_.malformed, answer.malformed ? 1 : 0);
  return answer.frame;
}

std::optional<Frame> SlcanAdapter::NextBufferedFrame() {
  while (input_at_ < input_size_) {
    const std::optional<slcan::Line> line = assembler_.Push(input_[input_at_++]);
    if (!line) continue;
    std::optional<Frame> frame = HandleLine(*line);
    if (!frame) continue;
    frame->receive_time_ns = RealTimeNs();
    Counters::Add(counters_.received);
    return frame;
  }
  return std::nullopt;
}

std::optional<Frame> SlcanAdapter::Receive() noexcept {
  constexpr int kMaxReads = 16;  // a client that pours out commands does not keep the caller here
  for (int i = 0; i < kMaxReads; ++i) {
    if (const std::optional<Frame> frame = NextBufferedFrame()) return frame;
    const std::ptrdiff_t size = pty_.Read(input_);
    if (size < 0) {
      Disconnect();
      return std::nullopt;
    }
    connected_ = true;
    input_at_ = 0;
    input_size_ = static_cast<std::size_t>(size);
    if (size == 0) return std::nullopt;
  }
  return std::nullopt;
}

SendResult SlcanAdapter::Send(const Frame& frame) noexcept {
  const std::lock_guard lock(mutex_);
  if (!session_.IsOpen()) return counters_.Count(SendResult::kDisconnected);
  const Clock::time_point now = Clock::now();
  const auto timestamp = session_.HasTimestamps() ? std::optional(TimestampMs(now)) : std::nullopt;
  const slcan::Outbox::Outcome outcome = outbox_.Write(slcan::FormatFrame(frame, timestamp).View(), now);
  if (outcome.lost_frames > 0 || !outcome.written) session_.SetOverrun();
  Counters::Add(counters_.dropped_queue_full, outcome.lost_frames);
  return counters_.Count(outcome.written ? SendResult::kSent : SendResult::kQueueFull);
}

}  // namespace servohil::can
