#include "run_report.hpp"

#include "formatted.hpp"

namespace servohil::app {
namespace {

double Us(std::uint64_t ns) {
  return static_cast<double>(ns) / 1e3;
}
double Ms(std::int64_t ns) {
  return static_cast<double>(ns) / 1e6;
}

const char* Name(Mode mode) {
  switch (mode) {
    case Mode::kWaiting:
      return "waiting";
    case Mode::kRunning:
      return "running";
    case Mode::kModelFault:
      return "MODEL FAULT";
    case Mode::kStopped:
      return "stopped";
  }
  return "?";
}

}  // namespace

std::string StatusLine(const Telemetry& t, double ticks_per_s, const can::BusStatistics& bus) {
  return Formatted(
      "%s  t %.1f s  %.0f ticks/s  worst latency %.3f ms  late ticks %llu  P1 %.3f psi  x3 %.4f in  "
      "frames in %llu out %llu",
      Name(t.status.mode), static_cast<double>(t.sample.tick) * model::kTickS, ticks_per_s,
      Ms(t.status.worst_lateness_ns), static_cast<unsigned long long>(t.status.late_ticks), t.sample.p1_psi,
      t.sample.state.x3_in, static_cast<unsigned long long>(bus.received),
      static_cast<unsigned long long>(bus.sent));
}

std::string Summary(const Emulator& emulator, const can::Network& network, const LoopSettings& loop) {
  const Telemetry end = emulator.Final();
  const rt::LoopTiming& timing = emulator.Timing();
  const TrafficCounters& traffic = emulator.Traffic();
  const auto count = [](const std::atomic<std::uint64_t>& c) {
    return static_cast<unsigned long long>(c.load());
  };
  std::string text;
  text += Formatted("ran      %llu ticks, %.4f s simulated; x3 %.4f in, P1 %.3f psi, P3 %.2f psi, mode %s\n",
                    static_cast<unsigned long long>(end.sample.tick),
                    static_cast<double>(end.sample.tick) * model::kTickS, end.sample.state.x3_in,
                    end.sample.p1_psi, end.sample.state.p3_psi, Name(end.status.mode));
  text += Formatted("wake-up  every %.1f ms; latency median %.1f us, 99.9 %% %.1f us, worst %.1f us; ",
                    static_cast<double>(loop.wake_ticks) / 10.0, Us(timing.wake_latency.QuantileNs(0.5)),
                    Us(timing.wake_latency.QuantileNs(0.999)), Us(timing.wake_latency.MaxNs()));
  text += Formatted("late ticks %llu, worst lateness %.3f ms\n",
                    static_cast<unsigned long long>(end.status.late_ticks), Ms(timing.worst_lateness_ns));
  text += Formatted("model    %llu ticks were faster than %d sub-steps resolve\n",
                    static_cast<unsigned long long>(end.sample.unresolved_ticks), model::kMaxSubSteps);
  text += Formatted(
      "compute  per wake-up median %.2f us, 99.9 %% %.2f us, worst %.2f us; page faults in the loop %ld\n",
      Us(timing.compute.QuantileNs(0.5)), Us(timing.compute.QuantileNs(0.999)), Us(timing.compute.MaxNs()),
      emulator.LoopPageFaults());
  text += Formatted("in       %llu commands, %llu of other ids, %llu malformed, %llu out of range\n",
                    count(traffic.commands), count(traffic.foreign), count(traffic.malformed),
                    count(traffic.out_of_range));
  text += Formatted("out      %llu published, %llu not sent, %llu superseded, %llu lost in the program\n",
                    count(traffic.published), count(traffic.not_sent), count(traffic.superseded),
                    static_cast<unsigned long long>(emulator.TelemetryDropped()));
  for (const auto& bus : network.Buses()) {
    const can::BusStatistics s = bus->Statistics();
    const std::string state = bus->State();
    text += Formatted(
        "bus      %s%s%s: %llu in, %llu out, %llu dropped (queue full), %llu dropped (not connected), "
        "%llu receive overflows, %llu malformed\n",
        bus->Name().c_str(), state.empty() ? "" : ", ", state.c_str(),
        static_cast<unsigned long long>(s.received), static_cast<unsigned long long>(s.sent),
        static_cast<unsigned long long>(s.dropped_queue_full),
        static_cast<unsigned long long>(s.dropped_disconnected),
        static_cast<unsigned long long>(s.receive_overflows), static_cast<unsigned long long>(s.malformed));
  }
  text += "verdict  " + JudgeRun(end).text + '\n';
  return text;
}

Verdict JudgeRun(const Telemetry& final) {
  std::string reasons;
  if (!final.status.timing_valid) {
    reasons += Formatted("timing: %llu late ticks, the worst began %.3f ms after its deadline",
                         static_cast<unsigned long long>(final.status.late_ticks),
                         Ms(final.status.worst_lateness_ns));
  }
  if (final.sample.model_fault) {
    reasons += Formatted("%smodel: the state left the model's domain after x3 = %.6g in",
                         reasons.empty() ? "" : "; ", final.sample.state.x3_in);
  }
  if (reasons.empty()) return {true, "VALID"};
  return {false, "INVALID: " + reasons};
}

}  // namespace servohil::app
