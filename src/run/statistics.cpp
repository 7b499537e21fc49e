#include "run/statistics.hpp"

#include "base/formatted.hpp"
#include "control/status.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.hpp"

namespace servohil::run {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson ToJson(const rt::LatencyHistogram& h) {
  return {
      {"count", h.Count()},           {"p50_ns", h.QuantileNs(0.5)},     {"p90_ns", h.QuantileNs(0.9)},
      {"p99_ns", h.QuantileNs(0.99)}, {"p99_9_ns", h.QuantileNs(0.999)}, {"p99_99_ns", h.QuantileNs(0.9999)},
      {"max_ns", h.MaxNs()}};
}

OrderedJson LateToJson(const simulation::Status& status, int max_catch_up_ticks) {
  return {{"ticks", status.late.Total()},
          {"woke_late_ticks", status.late.woke_late},
          {"computed_long_ticks", status.late.computed_long},
          {"both_ticks", status.late.both},
          {"in_grace_ticks", status.late.in_grace},
          {"worst_lateness_ns", status.worst_lateness_ns},
          {"overruns", status.overruns},
          {"max_catch_up_ticks", max_catch_up_ticks}};
}

OrderedJson WorstToJson(const emulator::Emulator& emulator, int wake_ticks) {
  OrderedJson worst = OrderedJson::array();
  for (const auto& [tick, late] : WorstOverruns(emulator, wake_ticks)) {
    worst.push_back({{"tick", tick},
                     {"lateness_ns", late.lateness_ns},
                     {"compute_ns", late.compute_ns},
                     {"behind_ticks", late.behind * static_cast<std::uint64_t>(wake_ticks)},
                     {"cause", NameOf(late.cause)},
                     {"cpu", late.cpu},
                     {"in_grace", late.in_grace}});
  }
  return worst;
}

OrderedJson SafetyToJson(const simulation::Status& status) {
  return {{"state", simulation::NameOf(status.safety)},
          {"cause", simulation::NameOf(status.safety_cause)},
          {"losses", status.losses},
          {"trips", status.trips}};
}

OrderedJson TrafficToJson(const emulator::Emulator& emulator) {
  const emulator::ReceiveCounters& in = emulator.Received();
  const emulator::SendCounters& out = emulator.Sent();
  OrderedJson json = {{"foreign", in.foreign.load()}};
  for (std::size_t i = 0; i < simulation::kFrameVerdicts; ++i)
    json[simulation::kFrameVerdictNames[i]] = in.of[i].load();
  json["lost"] = in.lost.load();
  json["published"] = out.published.load();
  json["not_sent"] = out.not_sent.load();
  json["superseded"] = out.superseded.load();
  json["unchanged"] = out.unchanged.load();
  json["saturated"] = control::SaturatedToJson(emulator);
  return json;
}

void Replace(const std::filesystem::path& file, const std::string& text) {
  const std::filesystem::path beside = file.string() + ".tmp";
  std::ofstream out(beside);
  out << text;
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(beside, file, error);
  if (!out || error)
    throw base::EnvironmentError(file.string() + ": cannot be written (disk full, or no permission?)");
}

}  // namespace

OrderedJson StatisticsToJson(const emulator::Emulator& emulator, const simulation::RunState& now,
                             const can::Network& network, const emulator::EmulatorOptions& options,
                             bool finished) {
  const rt::LoopTiming& timing = emulator.Timing();
  OrderedJson json = {{"program", "servohil " SERVOHIL_VERSION},
                      {"finished", finished},
                      {"clock", options.clock == emulator::Clock::kReal ? "real" : "lockstep"},
                      {"tick", now.sample.tick},
                      {"mode", simulation::NameOf(now.status.mode)},
                      {"safety", SafetyToJson(now.status)},
                      {"timing_valid", now.status.TimingValid()},
                      {"wake_ticks", options.task.loop.wake_ticks},
                      {"late", LateToJson(now.status, options.task.loop.max_catch_up_ticks)},
                      {"wake_latency", ToJson(timing.wake_latency)},
                      {"lateness", ToJson(timing.lateness)},
                      {"compute", ToJson(timing.compute)},
                      {"arrival_to_tick", ToJson(emulator.ArrivalToTick())},
                      {"arrival_to_frame", ToJson(emulator.ArrivalToFrame())},
                      {"traffic", TrafficToJson(emulator)}};
  if (finished) {
    const std::uint64_t lost =
        options.clock == emulator::Clock::kReal ? 0 : network.Statistics().receive_overflows;
    json["verdict"] = JudgeRun(now, lost, emulator.ModelledBus()).Text();
    json["state_hash"] = base::HashText(now.sample.state_hash);
    json["worst_overruns"] = WorstToJson(emulator, options.task.loop.wake_ticks);
    json["loop_page_faults"] = emulator.LoopPageFaults();
  }
  return json;
}

void WriteStatistics(const std::filesystem::path& file, const emulator::Emulator& emulator,
                     const simulation::RunState& now, const can::Network& network,
                     const emulator::EmulatorOptions& options, bool finished) {
  Replace(file, StatisticsToJson(emulator, now, network, options, finished).dump(2) + '\n');
}

}  // namespace servohil::run
