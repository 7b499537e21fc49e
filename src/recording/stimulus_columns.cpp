#include "recording/stimulus_columns.hpp"

#include <vector>

#include "simulation/quantity.hpp"

namespace servohil::recording {
namespace {

using I = Stimulus;
using U64 = std::uint64_t;
using U32 = std::uint32_t;
using U8 = std::uint8_t;

constexpr const char* kTick = "0.1 ms";

/// ": 0 x3_in, 1 v3_in_s, ..."
std::string QuantityNumbers() {
  std::string text;
  for (const simulation::Quantity& quantity : simulation::Quantities())
    text +=
        (text.empty() ? ": " : ", ") + std::to_string(simulation::IndexOf(quantity)) + " " + quantity.name;
  return text;
}

std::vector<StimulusColumn> MakeColumns() {
  return {
      {"tick", kTick, "the first that feels it", +[](I& i) -> U64& { return i.tick; }},
      {"kind", "",
       "0 fault injected, 1 fault cleared, 2 all faults cleared, 3 P1 set locally, 5 a frame came that a "
       "fault waited for, 6 command frame, 7 supervision of the command",
       +[](I& i) -> simulation::Request::Kind& { return i.request.kind; }},
      {"p1_psi", "psi", "command: control pressure demanded",
       +[](I& i) -> double& { return i.request.p1_psi; }},
      {"fault", "", "its number in the catalogue; `servohil fault list` has them",
       +[](I& i) -> U8& { return i.request.injection.id; }},
      {"target", "",
       "fault: the quantity of a sensor, or the number of a published message; 255: all" + QuantityNumbers(),
       +[](I& i) -> U8& { return i.request.injection.target; }},
      {"value_0", "", "parameter of the fault, in the catalogue's order",
       +[](I& i) -> double& { return i.request.injection.values[0]; }},
      {"value_1", "", "parameter of the fault, in the catalogue's order",
       +[](I& i) -> double& { return i.request.injection.values[1]; }},
      {"value_2", "", "parameter of the fault, in the catalogue's order",
       +[](I& i) -> double& { return i.request.injection.values[2]; }},
      {"seed", "", "fault: of what is random in it", +[](I& i) -> U64& { return i.request.injection.seed; }},
      {"start_tick", kTick, "fault: from then on",
       +[](I& i) -> U64& { return i.request.injection.start_tick; }},
      {"ramp_ticks", kTick, "fault: in", +[](I& i) -> U64& { return i.request.injection.ramp_ticks; }},
      {"ramp_out_ticks", kTick, "fault: out again",
       +[](I& i) -> U64& { return i.request.injection.ramp_out_ticks; }},
      {"for_ticks", kTick, "fault: of a pulse; 0: until cleared",
       +[](I& i) -> U64& { return i.request.injection.for_ticks; }},
      {"period_ticks", kTick, "fault: between the starts of its pulses; 0: none",
       +[](I& i) -> U64& { return i.request.injection.period_ticks; }},
      {"times", "", "fault: how many pulses; 0: without end",
       +[](I& i) -> U32& { return i.request.injection.times; }},
      {"waits", "", "fault: for its trigger", +[](I& i) -> bool& { return i.request.injection.waits; }},
      {"trigger", "", "fault: 0 time, 1 condition, 2 frame, 3 another fault",
       +[](I& i) -> fault::Trigger::Kind& { return i.request.injection.trigger.kind; }},
      {"quantity", "", "condition: of this one" + QuantityNumbers(),
       +[](I& i) -> U8& { return i.request.injection.trigger.quantity; }},
      {"above", "", "condition: 1 above, 0 below the threshold",
       +[](I& i) -> bool& { return i.request.injection.trigger.above; }},
      {"threshold", "", "condition: in the quantity's unit",
       +[](I& i) -> double& { return i.request.injection.trigger.threshold; }},
      {"frame_id", "", "trigger: identifier of the frame",
       +[](I& i) -> U32& { return i.request.injection.trigger.frame_id; }},
      {"extended", "", "trigger: the identifier has 29 bits",
       +[](I& i) -> bool& { return i.request.injection.trigger.extended; }},
      {"trigger_fault", "", "trigger: number of the other fault",
       +[](I& i) -> U8& { return i.request.injection.trigger.fault; }},
      {"safety_state", "", "supervision: the state it came to",
       +[](I& i) -> simulation::SafetyState& { return i.request.safety; }, false},
      {"safety_cause", "", "supervision: why",
       +[](I& i) -> simulation::SafetyCause& { return i.request.safety_cause; }, false},
  };
}

static_assert(fault::kMaxParameters == 3, "one column for each");

}  // namespace

std::span<const StimulusColumn> StimulusColumns() {
  static const std::vector<StimulusColumn> columns = MakeColumns();
  return columns;
}

}  // namespace servohil::recording
