#include "run/report.hpp"
#include "model/ticks.hpp"

#include <algorithm>

#include "base/formatted.hpp"
#include "signal_map/report.hpp"

namespace servohil::run {
namespace {

using Count = unsigned long long;  // for printf
using V = simulation::FrameVerdict;

double Us(std::uint64_t ns) {
  return static_cast<double>(ns) / 1e3;
}
double Ms(std::int64_t ns) {
  return static_cast<double>(ns) / 1e6;
}

std::string Quantiles(const rt::LatencyHistogram& h) {
  return base::Formatted("median %.1f us, 99.9 %% %.1f us, worst %.1f us", Us(h.QuantileNs(0.5)),
                         Us(h.QuantileNs(0.999)), Us(h.MaxNs()));
}

std::string LateSummary(const simulation::LateTicks& late, std::int64_t worst_ns) {
  return base::Formatted(
      "late ticks %llu (%llu woke late, %llu computed long, %llu both), worst lateness %.3f ms",
      Count{late.Total()}, Count{late.woke_late}, Count{late.computed_long}, Count{late.both}, Ms(worst_ns));
}

std::string TimingSummary(const emulator::Emulator& emulator, const emulator::EmulatorOptions& options) {
  const simulation::Status& status = emulator.Final().status;
  const rt::LoopTiming& timing = emulator.Timing();
  const int wake_ticks = options.task.loop.wake_ticks;
  std::string text = base::Formatted("wake-up  every %.1f ms; latency ", wake_ticks / 10.0) +
                     Quantiles(timing.wake_latency) + "; " +
                     LateSummary(status.late, status.worst_lateness_ns) + '\n';
  for (const auto& [tick, late] : WorstOverruns(emulator, wake_ticks)) {
    text += base::Formatted(
        "late     at tick %llu by %.3f ms, %s: longest compute before it %.3f ms, %llu ticks behind, CPU "
        "%d%s\n",
        Count{tick}, Ms(late.lateness_ns), NameOf(late.cause), Ms(late.compute_ns),
        Count{late.behind * static_cast<std::uint64_t>(wake_ticks)}, late.cpu,
        late.in_grace ? ", in the start-up grace" : "");
  }
  if (status.late.in_grace > 0)
    text += base::Formatted("grace    %llu late ticks in the first %d ms do not count\n",
                            Count{status.late.in_grace}, options.task.loop.grace_ms);
  if (status.overruns > 0)
    text += base::Formatted("overrun  %llu times more than %d ticks were to be caught up\n",
                            Count{status.overruns}, options.task.loop.max_catch_up_ticks);
  text += "compute  per wake-up " + Quantiles(timing.compute) +
          base::Formatted("; page faults in the loop %ld\n", emulator.LoopPageFaults());
  text += "command  from arrival to its first tick " + Quantiles(emulator.ArrivalToTick()) +
          "; to its first frame " + Quantiles(emulator.ArrivalToFrame()) + '\n';
  return text;
}

std::string SafetySummary(const emulator::ReceiveCounters& in, const simulation::Status& end) {
  std::string text = base::Formatted(
      "safety   %s (%s), %llu times lost, %llu trips; refused:", simulation::NameOf(end.safety),
      simulation::NameOf(end.safety_cause), Count{end.losses}, Count{end.trips});
  for (const V verdict : {V::kCorrupted, V::kRepeated, V::kStuck, V::kReordered, V::kJumped, V::kStale,
                          V::kTooFast, V::kNotAvailable, V::kErrorIndicator})
    text += base::Formatted(" %llu %s,", Count{in.Of(verdict)}, simulation::NameOf(verdict));
  return text + base::Formatted(" %llu never came\n", Count{in.lost.load()});
}

std::string SaturationSummary(const signal_map::SignalMap& signal_map, const emulator::SendCounters& out) {
  std::string text;
  for (std::size_t i = 0; i < signal_map.MessageCount(); ++i) {
    if (const std::uint64_t frames = out.saturated[i].load(); frames > 0) {
      text +=
          base::Formatted("clipped  %llu frames of ", Count{frames}) +
          signal_map::DescribeSaturation(signal_map.OutgoingMessages()[i], out.saturated_fields[i].load()) +
          '\n';
    }
  }
  return text;
}

}  // namespace

const char* NameOf(rt::LateCause cause) {
  switch (cause) {
    case rt::LateCause::kWokeLate:
      return "woke late";
    case rt::LateCause::kComputedLong:
      return "computed long";
    default:
      return "woke late and computed long";
  }
}

std::string ReadyLine(const can::Network& network, const simulation::RunState& start,
                      const emulator::EmulatorOptions& options) {
  std::string text = "ready: ";
  for (const auto& bus : network.Buses()) text += (bus == network.Buses().front() ? "" : ", ") + bus->Name();
  text +=
      base::Formatted("; %s x3 %.4f in, P1 %.4f psi", start.status.commanded ? "goes on at" : "at rest at",
                      start.sample.state.x3_in, start.sample.p1_psi);
  if (!start.status.commanded) text += ", until the first command";
  if (options.clock == emulator::Clock::kReal)
    return text + base::Formatted("; wake-up every %.1f ms\n", options.task.loop.wake_ticks / 10.0);
  return text + base::Formatted("; lockstep: %.1f ms per ", options.lockstep.ticks / 10.0) +
         (options.lockstep.sync_id < 0 ? "command"
                                       : base::Formatted("frame 0x%X", options.lockstep.sync_id)) +
         "\n";
}

std::string StatusLine(const simulation::RunState& t, double ticks_per_s, const emulator::Emulator& emulator,
                       const can::BusStatistics& bus) {
  const rt::LatencyHistogram& latency = emulator.Timing().wake_latency;
  return base::Formatted(
      "%s  t %.1f s  %.0f ticks/s  wake-up latency 99.9 %% %.3f ms, worst %.3f ms  late ticks %llu  P1 %.3f "
      "psi  "
      "x3 %.4f in  frames in %llu out %llu",
      simulation::NameOf(t.status.mode), model::SecondsOf(t.sample.tick), ticks_per_s,
      Us(latency.QuantileNs(0.999)) / 1e3, Us(latency.MaxNs()) / 1e3, Count{t.status.late.Total()},
      t.sample.p1_psi, t.sample.state.x3_in, Count{bus.received}, Count{bus.sent});
}

std::string SimulationSummary(const simulation::RunState& end) {
  const simulation::Sample& s = end.sample;
  return base::Formatted(
             "ran      %llu ticks, %.4f s simulated; x3 %.4f in, P1 %.3f psi, P3 %.2f psi, mode %s\n",
             Count{s.tick}, model::SecondsOf(s.tick), s.state.x3_in, s.p1_psi, s.state.p3_psi,
             simulation::NameOf(end.status.mode)) +
         "hash     " + base::HashText(s.state_hash) + '\n' +
         base::Formatted("model    %llu ticks were faster than %d sub-steps resolve\n",
                         Count{s.unresolved_ticks}, model::kMaxSubSteps);
}

std::string Summary(const emulator::Emulator& emulator, const can::Network& network,
                    const emulator::EmulatorOptions& options) {
  const emulator::ReceiveCounters& in = emulator.Received();
  const emulator::SendCounters& out = emulator.Sent();
  const auto count = [](const std::atomic<std::uint64_t>& c) { return Count{c.load()}; };
  std::string text = SimulationSummary(emulator.Final());
  if (options.clock == emulator::Clock::kReal) text += TimingSummary(emulator, options);
  text += base::Formatted(
      "in       %llu commands, %llu of other ids, %llu malformed, %llu out of range, "
      "%llu with our ids\n",
      Count{in.Of(simulation::FrameVerdict::kValid)}, count(in.foreign),
      Count{in.Of(simulation::FrameVerdict::kMalformed)}, Count{in.Of(simulation::FrameVerdict::kOutOfRange)},
      count(in.conflicting));
  text += SafetySummary(in, emulator.Final().status);
  text +=
      base::Formatted("out      %llu published, %llu not sent, %llu superseded, %llu lost in the program\n",
                      count(out.published), count(out.not_sent), count(out.superseded),
                      Count{emulator.PublicationsDropped()});
  text += SaturationSummary(emulator.Frames(), out);
  if (const auto modelled = emulator.ModelledBus()) {
    text += base::Formatted(
        "emulated %llu frames passed the bus in their turn, ours after at most %.3f ms; at most %.1f %% of "
        "it "
        "asked for within 100 ms, %llu cycles missed, %llu dropped (queue full), %llu of others dropped\n",
        Count{modelled->frames}, Ms(modelled->worst_delay_ns), 100.0 * modelled->worst_load,
        Count{modelled->missed_cycles}, Count{modelled->dropped}, Count{modelled->others_dropped});
  }
  for (const auto& bus : network.Buses()) {
    const can::BusStatistics s = bus->Statistics();
    const std::string state = bus->State();
    text += base::Formatted(
        "bus      %s%s%s: %llu in, %llu out, %llu dropped (queue full), %llu dropped (not connected), "
        "%llu receive overflows, %llu malformed, %llu error frames\n",
        bus->Name().c_str(), state.empty() ? "" : ", ", state.c_str(), Count{s.received}, Count{s.sent},
        Count{s.dropped_queue_full}, Count{s.dropped_disconnected}, Count{s.receive_overflows},
        Count{s.malformed}, Count{s.error_frames});
  }
  return text;
}

std::vector<WorstOverrun> WorstOverruns(const emulator::Emulator& emulator, int wake_ticks) {
  std::vector<WorstOverrun> worst;
  for (const rt::LateWake& late : emulator.Timing().late.Worst())
    worst.push_back(
        {emulator.FirstTick() + (late.wake - 1) * static_cast<std::uint64_t>(wake_ticks) + 1, late});
  std::sort(worst.begin(), worst.end(),
            [](const WorstOverrun& a, const WorstOverrun& b) { return a.tick < b.tick; });
  return worst;
}

std::string Verdict::Text() const {
  if (Valid()) return "VALID";
  std::string text = "INVALID: ";
  for (const std::string& reason : reasons) text += (&reason == &reasons.front() ? "" : "; ") + reason;
  return text;
}

Verdict JudgeRun(const simulation::RunState& end, std::uint64_t lost_frames,
                 const std::optional<can::BusModelStatistics>& modelled) {
  Verdict verdict;
  if (!end.status.TimingValid())
    verdict.reasons.push_back("timing: " + LateSummary(end.status.late, end.status.worst_lateness_ns));
  if (end.status.mode == simulation::Mode::kFrozen)
    verdict.reasons.emplace_back("overrun: simulated time was frozen (loop.overrun = \"freeze\")");
  if (end.sample.model_fault) {
    verdict.reasons.push_back(base::Formatted("model: the state left the model's domain after x3 = %.6g in",
                                              end.sample.state.x3_in));
  }
  if (lost_frames > 0) {
    verdict.reasons.push_back(base::Formatted(
        "lockstep: %llu frames were lost before they could be received: the governor must wait for "
        "the answer "
        "to each",
        Count{lost_frames}));
  }
  if (modelled && modelled->Failed()) {
    verdict.reasons.push_back(base::Formatted(
        "bus: this schedule fails on a real one: %llu cycles missed, %llu frames dropped (queue full), up to "
        "%.1f %% of the bus asked for",
        Count{modelled->missed_cycles}, Count{modelled->dropped}, 100.0 * modelled->worst_load));
  }
  return verdict;
}

}  // namespace servohil::run
