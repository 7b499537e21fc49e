#include "run/watch.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/error.hpp"
#include "fault_words/injection_words.hpp"
#include "run/report.hpp"
#include "run/statistics.hpp"
#include "signal_map/report.hpp"

namespace servohil::run {
namespace {

constexpr int kLookEveryMs = 100;

}  // namespace

Watch::Watch(emulator::Emulator& emulator, const can::Network& network,
             const emulator::EmulatorOptions& options, std::filesystem::path statistics,
             const SnapshotWriter& snapshots, control::Server* control, Reloader& reloader, BusWatch& buses)
    : emulator_(emulator),
      network_(network),
      options_(options),
      statistics_(std::move(statistics)),
      snapshots_(snapshots),
      control_(control),
      reloader_(reloader),
      buses_(buses),
      now_(emulator.Final()),
      terminal_(isatty(STDOUT_FILENO) != 0),
      last_ns_(base::MonotonicNs()) {
  if (control_ != nullptr) {
    control_->AnswerStatisticsBy(
        [this] { return nlohmann::json(StatisticsToJson(emulator_, now_, network_, options_, false)); });
  }
}

void Watch::Run(const StopSignals& signals) {
  manager_.TellReady();
  for (bool ended = false; !ended;) {
    ended = Wait(signals);
    ended = TakeSignals(signals) || ended;
    emulator_.TakeNewest(now_);
    LogWhatWentWrong();
    LogFrames();
    LogSilentGovernor();
    LogSafetyChanges();
    LogFaults();
    LogSaturation();
    buses_.Look();
    NotifyWatchdog();
    if (control_ != nullptr) control_->Serve(now_, buses_.Reports());
    snapshots_.WriteAllOrTell(emulator_);
    if (base::MonotonicNs() - last_ns_ >= base::kNsPerS) TellEachSecond();
  }
  if (const std::string text = frames_.Rest(now_.status.frames); !text.empty()) spdlog::warn("{}", text);
  manager_.TellStopping();
  if (terminal_) std::cout << '\n';
}

/// Only while the simulation's loop goes on: one that hangs lets the watchdog bite.
void Watch::NotifyWatchdog() {
  const std::uint64_t turns = emulator_.LoopIterations();
  if (turns != loop_iterations_) manager_.TellAlive();
  loop_iterations_ = turns;
}

bool Watch::Wait(const StopSignals& signals) {
  std::vector<pollfd> descriptors = {{signals.Fd(), POLLIN, 0}, {emulator_.FinishedFd(), POLLIN, 0}};
  if (control_ != nullptr) control_->AddTo(descriptors);
  poll(descriptors.data(), descriptors.size(),
       control_ != nullptr ? control_->PollTimeoutMs() : kLookEveryMs);
  return descriptors[1].revents != 0;
}

bool Watch::TakeSignals(const StopSignals& signals) {
  bool end = false;
  while (const int signal = signals.Next()) {
    if (signal == SIGUSR1) {
      emulator_.PutRequest({.kind = simulation::Request::Kind::kSnapshot});
    } else if (signal == SIGHUP && !terminal_) {  // from a terminal that closes it is the end
      Reload();
    } else {
      end = true;
    }
  }
  return end;
}

void Watch::Reload() {
  manager_.TellReloading();
  reloader_.Reload();
  manager_.TellReady();
}

void Watch::LogWhatWentWrong() {
  const simulation::Status& status = now_.status;
  const configuration::LoopSettings& loop = options_.task.loop;
  if (status.overruns != overruns_) {
    overruns_ = status.overruns;
    spdlog::error(
        "overrun: more than loop.max_catch_up_ticks = {} were to be caught up; loop.overrun = \"{}\"",
        loop.max_catch_up_ticks,
        configuration::NamesOf(loop.overrun)[static_cast<std::size_t>(loop.overrun)]);
  }
  if (timing_valid_ && !status.TimingValid()) {
    timing_valid_ = false;
    spdlog::warn("late ticks before tick {}: the run is INVALID", now_.sample.tick);
  }
}

void Watch::LogFrames() {
  const std::string text = frames_.Look(now_.status.frames, base::MonotonicNs());
  if (!text.empty()) spdlog::warn("{}", text);
}

/// Once: on a bus that filters identifiers, a governor that sends another one is not even seen.
void Watch::LogSilentGovernor() {
  constexpr std::uint64_t kPatienceTicks = 50'000;
  const simulation::FrameCounts& frames = now_.status.frames;
  const bool silent = !now_.status.commanded && frames.Valid() + frames.Rejected() == 0;
  if (told_silence_ || !silent || now_.sample.tick < kPatienceTicks) return;
  told_silence_ = true;
  const can::Message& message = emulator_.Frames().CommandMessage();
  spdlog::info(
      "no {} ({}) so far: does the governor send it with this identifier? candump shows what there is{}",
      message.name, signal_map::IdText(message.id, message.extended),
      message.extended && !emulator_.Frames().IncomingMessages().front().pattern.pgn
          ? "; J1939 of any source address: can.command.pgn = true"
          : "");
}

void Watch::LogSafetyChanges() {
  simulation::SafetyChange change;
  while (emulator_.TryPopSafetyChange(change)) {
    const bool well = change.to == simulation::SafetyState::kRunning;
    spdlog::log(well ? spdlog::level::info : spdlog::level::warn,
                "command: {} from tick {} on, {} before: {}{}", simulation::NameOf(change.to), change.tick,
                simulation::NameOf(change.from), simulation::NameOf(change.cause),
                change.to == simulation::SafetyState::kDegraded ? OnLossText(change.cause) : "");
  }
}

std::string Watch::OnLossText(simulation::SafetyCause cause) const {
  const configuration::OnLoss on_loss = options_.safety.on_loss;
  using Cause = simulation::SafetyCause;
  const bool by_time = cause == Cause::kSilence || cause == Cause::kInvalidFrames;
  return (by_time ? TimeOutText() : std::string()) + std::string("; safety.on_loss = \"") +
         configuration::NamesOf(on_loss)[static_cast<std::size_t>(on_loss)] + '"';
}

/// " for 150 ms (three cycles of 50 ms: governor.dbc:12, GenMsgCycleTime)"
std::string Watch::TimeOutText() const {
  const std::string time = " for " + std::to_string(options_.safety.timeout_ms) + " ms (";
  if (!options_.safety.timeout_is_of_cycle) return time + "safety.timeout_ms)";
  return time + "three cycles of " + std::to_string(options_.command_cycle_ms) +
         " ms: " + emulator_.Frames().IncomingMessages().front().cycle_from + ")";
}

/// Each signal once.
void Watch::LogSaturation() {
  const auto messages = emulator_.Frames().OutgoingMessages();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const signal_map::FieldSet fields =
        emulator_.Sent().saturated_fields[i].load(std::memory_order_relaxed) & ~told_saturated_[i];
    if (fields == 0) continue;
    told_saturated_[i] |= fields;
    spdlog::warn("{}", signal_map::DescribeSaturation(messages[i], fields));
  }
}

/// Each start and end; of a row of pulses the first, and the others for who wants to know all.
void Watch::LogFaults() {
  fault::Event event;
  while (emulator_.TryPopFaultEvent(event)) {
    const std::string text = fault_words::EventText(event, &emulator_.Frames());
    spdlog::log(event.pulse == 0 ? spdlog::level::info : spdlog::level::debug, text);
  }
  if (snapshots_refused_ == emulator_.SnapshotsRefused()) return;
  snapshots_refused_ = emulator_.SnapshotsRefused();
  spdlog::warn("no snapshot: it cannot hold the past that sensor_delayed needs; clear it first");
}

/// The run goes on without; at its end it is an error.
void Watch::WriteStatisticsSoFar() {
  if (statistics_.empty()) return;
  try {
    WriteStatistics(statistics_, emulator_, now_, network_, options_, false);
  } catch (const base::EnvironmentError& error) {
    spdlog::error("{}", error.what());
    statistics_.clear();
  }
}

void Watch::TellEachSecond() {
  const std::int64_t now_ns = base::MonotonicNs();
  if (terminal_ || manager_.Exists()) {
    const double ticks_per_s =
        static_cast<double>(now_.sample.tick - last_tick_) * 1e9 / static_cast<double>(now_ns - last_ns_);
    const std::string line = StatusLine(now_, ticks_per_s, emulator_, network_.Statistics());
    manager_.TellStatus(line);
    if (terminal_) std::cout << "\r\033[K" << line << std::flush;
  }
  WriteStatisticsSoFar();
  last_ns_ = now_ns;
  last_tick_ = now_.sample.tick;
}

}  // namespace servohil::run
