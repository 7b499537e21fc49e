#include "recording/sample_columns.hpp"

#include <array>

namespace servohil::recording {
namespace {

using T = simulation::RunState;
using U64 = std::uint64_t;

constexpr std::array kColumns = std::to_array<SampleColumn>({
    {"tick", "0.1 ms", "simulated time since the start", +[](T& t) -> U64& { return t.sample.tick; }},
    {"p1_psi", "psi", "control pressure during the tick that ended here",
     +[](T& t) -> double& { return t.sample.p1_psi; }},
    {"x3_in", "in", "piston position", +[](T& t) -> double& { return t.sample.state.x3_in; }},
    {"v3_in_s", "in/s", "piston velocity", +[](T& t) -> double& { return t.sample.state.v3_in_s; }},
    {"p3_psi", "psi", "pressure under the piston", +[](T& t) -> double& { return t.sample.state.p3_psi; }},
    {"p4_psi", "psi", "pressure above the relay plunger",
     +[](T& t) -> double& { return t.sample.state.p4_psi; }},
    {"p8_psi", "psi", "pressure in the stabilizer's oil chamber; P3 without a stabilizer",
     +[](T& t) -> double& { return t.sample.state.p8_psi; }},
    {"p2_psi", "psi", "supply pressure", +[](T& t) -> double& { return t.sample.state.p2_psi; }},
    {"motion", "", "piston: 0 free, 1 stuck, 2 sliding up, 3 sliding down, 4 at lower stop, 5 at upper stop",
     +[](T& t) -> model::Motion& { return t.sample.state.mode.motion; }},
    {"plunger", "", "relay plunger: 0 free, 1 at lower stop, 2 at upper stop",
     +[](T& t) -> model::Plunger& { return t.sample.state.mode.plunger; }},
    {"diaphragm_seated", "", "1 while the stabilizer's diaphragm rests on its seat",
     +[](T& t) -> bool& { return t.sample.state.mode.diaphragm_seated; }},
    {"relay_port_full", "", "1 while orifice 5 is open to its height",
     +[](T& t) -> bool& { return t.sample.state.mode.relay_port_full; }},
    {"model_fault", "", "1 once the model left its domain; the state is then the last good one",
     +[](T& t) -> bool& { return t.sample.model_fault; }},
    {"unresolved_ticks", "ticks", "that needed more sub-steps than there are, so far",
     +[](T& t) -> U64& { return t.sample.unresolved_ticks; }},
    {"sub_steps", "", "integration steps of this tick; 0: at rest",
     +[](T& t) -> int& { return t.sample.sub_steps; }},
    {"state_hash", "", "over the states of all ticks so far",
     +[](T& t) -> U64& { return t.sample.state_hash; }, false},
    {"mode", "", "0 waiting for the first command, 1 running, 2 model fault, 4 frozen, 5 degraded, 6 tripped",
     +[](T& t) -> simulation::Mode& { return t.status.mode; }},
    {"commanded", "", "1 once a command has been received",
     +[](T& t) -> bool& { return t.status.commanded; }},
    {"safety_cause", "", "why the command's supervision came to be in its state; PROTOCOL.md has the numbers",
     +[](T& t) -> simulation::SafetyCause& { return t.status.safety_cause; }, true, true, false},
    {"command_age_ticks", "ticks", "since the newest command was first used",
     +[](T& t) -> U64& { return t.status.command_age_ticks; }},
    {"active_faults", "", "injected faults that act", +[](T& t) -> U64& { return t.status.active_faults; }},
    {"woke_late_ticks", "ticks", "late because the thread was woken late, since the start",
     +[](T& t) -> U64& { return t.status.late.woke_late; }, true, false},
    {"computed_long_ticks", "ticks", "late because the ticks before took long, since the start",
     +[](T& t) -> U64& { return t.status.late.computed_long; }, true, false},
    {"woke_late_and_computed_long_ticks", "ticks", "late for both reasons, since the start",
     +[](T& t) -> U64& { return t.status.late.both; }, true, false},
    {"worst_lateness_ns", "ns", "of a wake-up, since the start",
     +[](T& t) -> std::int64_t& { return t.status.worst_lateness_ns; }, true, false},
});

}  // namespace

std::span<const SampleColumn> SampleColumns() {
  return kColumns;
}

}  // namespace servohil::recording
