#include "simulation/quantity.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "model/ticks.hpp"
#include "simulation/publication.hpp"

namespace servohil::simulation {
namespace {

using T = RunState;

constexpr bool kMachines = false;  // doing: not repeatable

double Ms(std::int64_t ns) noexcept {
  return static_cast<double>(ns) / 1e6;
}

double CommandAgeMs(const T& t) noexcept {
  return t.status.commanded ? static_cast<double>(t.status.command_age_ticks) / model::kTicksPerMs
                            : std::numeric_limits<double>::infinity();
}

template <can::BusFault kFault>
double HasBusFault(const T& t) noexcept {
  return t.bus.Has(kFault) ? 1.0 : 0.0;
}

constexpr std::array kQuantities = std::to_array<Quantity>({
    {"x3_in", "X3", "in", "Piston position, upward opens the steam valves",
     [](const T& t) { return t.sample.state.x3_in; }},
    {"v3_in_s", "V3", "in/s", "Piston velocity", [](const T& t) { return t.sample.state.v3_in_s; }},
    {"tick", "Tick", "", "Simulated time in ticks of 0.1 ms since the start, modulo 2^32",
     [](const T& t) { return static_cast<double>(t.sample.tick & 0xFFFF'FFFFU); }},
    {"p1_psi", "P1_Applied", "psi", "Control oil pressure that the model used, gauge",
     [](const T& t) { return t.sample.p1_psi; }},
    {"p3_psi", "P3", "psi", "Pressure under the servomotor piston, gauge",
     [](const T& t) { return t.sample.state.p3_psi; }},
    {"p4_psi", "P4", "psi", "Pressure above the relay plunger, gauge",
     [](const T& t) { return t.sample.state.p4_psi; }},
    {"p8_psi", "P8", "psi",
     "Pressure in the stabilizer's oil chamber, gauge; P3 where there is no stabilizer",
     [](const T& t) { return t.sample.state.p8_psi; }},
    {"x1_in", "X1", "in", "Relay piston", [](const T& t) { return t.outputs.x1_in; }},
    {"x2_in", "X2", "in", "Relay plunger", [](const T& t) { return t.outputs.x2_in; }},
    {"x4_in", "X4", "in", "Relay bushing (feedback from the cam)",
     [](const T& t) { return t.outputs.x4_in; }},
    {"sub_steps", "SubSteps", "", "Integration steps that the newest tick of 0.1 ms took; 0: at rest",
     [](const T& t) { return static_cast<double>(t.sample.sub_steps); }},
    {"mode", "Mode", "", "State of the emulator",
     [](const T& t) { return static_cast<double>(t.status.mode); }},
    {"timing_valid", "TimingValid", "", "1 while no tick was late since the start; latched at 0",
     [](const T& t) { return t.status.TimingValid() ? 1.0 : 0.0; }, kMachines},
    {"model_fault", "ModelFault", "",
     "1 once the model left its domain; the values are then the last good ones",
     [](const T& t) { return t.sample.model_fault ? 1.0 : 0.0; }},
    {"stuck", "Stuck", "", "1 while Coulomb friction holds the piston",
     [](const T& t) { return t.sample.state.mode.PistonRests() ? 1.0 : 0.0; }},
    {"active_faults", "ActiveFaults", "", "Number of injected faults that act now",
     [](const T& t) { return static_cast<double>(t.status.active_faults); }},
    {"unresolved", "Unresolved", "", "1 once a tick needed more integration steps than are allowed; latched",
     [](const T& t) { return t.sample.unresolved_ticks > 0 ? 1.0 : 0.0; }},
    {"late_ticks", "LateTicks", "",
     "Ticks that began a wake period or more after their deadline, since the start",
     [](const T& t) { return static_cast<double>(t.status.late.Total()); }, kMachines},
    {"worst_lateness_ms", "WorstLateness", "ms", "Worst lateness of a wake-up since the start",
     [](const T& t) { return Ms(t.status.worst_lateness_ns); }, kMachines},
    {"recent_lateness_ms", "RecentLateness", "ms", "Worst lateness of a wake-up since it was told before",
     [](const T& t) { return Ms(t.status.recent_lateness_ns); }, kMachines},
    {"command_age_ms", "CommandAge", "ms", "Time since the newest valid command; none yet: infinite",
     CommandAgeMs},
    {"safety_state", "SafetyState", "", "What the run does with the command",
     [](const T& t) { return static_cast<double>(t.status.safety); }},
    {"safety_cause", "SafetyCause", "", "Why it came to be in this state",
     [](const T& t) { return static_cast<double>(t.status.safety_cause); }},
    {"command_losses", "CommandLosses", "", "Times that the command was lost, or not enabled any more",
     [](const T& t) { return static_cast<double>(t.status.losses); }},
    {"trips", "Trips", "", "Times that the governor tripped",
     [](const T& t) { return static_cast<double>(t.status.trips); }},
    {"valid_frames", "ValidFrames", "", "Valid command frames since the start",
     [](const T& t) { return static_cast<double>(t.status.frames.Valid()); }, kMachines},
    {"rejected_frames", "RejectedFrames", "", "Frames with the command's identifier that were not valid",
     [](const T& t) { return static_cast<double>(t.status.frames.Rejected()); }, kMachines},
    {"corrupted_frames", "CorruptedFrames", "", "Command frames with a wrong checksum",
     [](const T& t) { return static_cast<double>(t.status.frames.Of(FrameVerdict::kCorrupted)); }, kMachines},
    {"frames_out_of_sequence", "FramesOutOfSequence", "",
     "Command frames that were repeated, stuck, reordered, or came after too many lost ones",
     [](const T& t) { return static_cast<double>(t.status.frames.OutOfSequence()); }, kMachines},
    {"lost_frames", "LostFrames", "",
     "Command frames missing between those that came, as their counter tells",
     [](const T& t) { return static_cast<double>(t.status.frames.lost); }, kMachines},
    {"stale_frames", "StaleFrames", "", "Command frames that were too old when they were read",
     [](const T& t) { return static_cast<double>(t.status.frames.Of(FrameVerdict::kStale)); }, kMachines},
    {"bus_state", "BusState", "", "State of the bus; of several, the worst",
     [](const T& t) { return static_cast<double>(t.bus.state); }},
    {"bit_rate_mismatch", "BitRateMismatch", "",
     "1 while nothing but error frames comes: another bit rate, or broken wires",
     HasBusFault<can::BusFault::kBitRateMismatch>},
    {"no_acknowledge", "NoAcknowledge", "", "1 while nobody acknowledges frames",
     HasBusFault<can::BusFault::kNoAcknowledge>},
    {"queue_full", "QueueFull", "", "1 while frames find the transmit queue full, or stuck",
     HasBusFault<can::BusFault::kQueueFull>},
    {"receive_overrun", "ReceiveOverrun", "",
     "1 while frames are lost because they come faster than they are read",
     HasBusFault<can::BusFault::kReceiveOverrun>},
    {"id_conflict", "IdConflict", "", "1 while another node sends identifiers that are the emulator's",
     HasBusFault<can::BusFault::kIdConflict>},
    {"tx_errors", "TxErrors", "", "Transmit error counter of the controller",
     [](const T& t) { return static_cast<double>(t.bus.tx_errors); }},
    {"rx_errors", "RxErrors", "", "Receive error counter of the controller",
     [](const T& t) { return static_cast<double>(t.bus.rx_errors); }},
    {"error_frames", "ErrorFrames", "", "Error frames since the start",
     [](const T& t) { return static_cast<double>(t.bus.error_frames); }},
    {"frames_not_sent", "NotSent", "", "Frames not sent since the start: full queue, or no bus",
     [](const T& t) { return static_cast<double>(t.bus.not_sent); }},
    {"bus_offs", "BusOffs", "", "Times that the controller went bus-off since the start",
     [](const T& t) { return static_cast<double>(t.bus.bus_offs); }},
});

static_assert(kQuantities.size() <= kMaxQuantities);

}  // namespace

std::span<const Quantity> Quantities() noexcept {
  return kQuantities;
}

const Quantity* FindQuantity(std::string_view name) noexcept {
  const auto* const found = std::find_if(kQuantities.begin(), kQuantities.end(), [&](const Quantity& q) {
    return name == q.name || name == q.signal;
  });
  return found == kQuantities.end() ? nullptr : found;
}

}  // namespace servohil::simulation
