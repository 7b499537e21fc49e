#include "control/status.hpp"

#include <nlohmann/json.hpp>

#include "model/ticks.hpp"

namespace servohil::control {

namespace {

/// States, causes and what became of the frames with the command's identifier.
nlohmann::json SafetyToJson(const simulation::Status& status) {
  nlohmann::json frames = nlohmann::json::object();
  for (std::size_t i = 0; i < simulation::kFrameVerdicts; ++i)
    frames[simulation::kFrameVerdictNames[i]] = status.frames.of[i];
  frames["lost"] = status.frames.lost;
  return {{"state", simulation::NameOf(status.safety)},
          {"cause", simulation::NameOf(status.safety_cause)},
          {"losses", status.losses},
          {"trips", status.trips},
          {"frames", frames}};
}

}  // namespace

nlohmann::json StatusToJson(const simulation::RunState& now) {
  const simulation::Sample& s = now.sample;
  return {{"result", "OK"},
          {"tick", s.tick},
          {"time_s", model::SecondsOf(s.tick)},
          {"mode", simulation::NameOf(now.status.mode)},
          {"timing_valid", now.status.TimingValid()},
          {"late_ticks", now.status.late.Total()},
          {"worst_lateness_ms", static_cast<double>(now.status.worst_lateness_ns) / 1e6},
          {"p1_psi", s.p1_psi},
          {"x3_in", s.state.x3_in},
          {"v3_in_s", s.state.v3_in_s},
          {"p2_psi", s.state.p2_psi},
          {"p3_psi", s.state.p3_psi},
          {"p4_psi", s.state.p4_psi},
          {"p8_psi", s.state.p8_psi},
          {"stuck", s.state.mode.PistonRests()},
          {"model_fault", s.model_fault},
          {"active_faults", now.status.active_faults},
          {"safety", SafetyToJson(now.status)},
          {"interface_down", now.status.line_down},
          {"command_age_s", model::SecondsOf(now.status.command_age_ticks)}};
}

nlohmann::json SaturatedToJson(const emulator::Emulator& emulator) {
  nlohmann::json saturated = nlohmann::json::object();
  const signal_map::SignalMap& signal_map = emulator.Frames();
  for (std::size_t i = 0; i < signal_map.MessageCount(); ++i) {
    if (const std::uint64_t frames = emulator.Sent().saturated[i].load(); frames > 0)
      saturated[signal_map.MessageOf(i).name] = frames;
  }
  return saturated;
}

}  // namespace servohil::control
