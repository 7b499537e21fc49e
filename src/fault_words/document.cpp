#include "fault_words/document.hpp"

#include "base/formatted.hpp"
#include "fault/catalogue.hpp"
#include "fault_words/injection_words.hpp"

namespace servohil::fault_words {
namespace {

constexpr const char* kHead = R"(# Faults

<!-- `servohil fault list --markdown` writes this file from the catalogue; a test compares them. -->

What can be injected into a running servomotor: `servohil fault inject NAME PARAMETER=VALUE ...`. Besides their own,
faults have these parameters; `--at`, `--when`, `--when-frame`, `--when-fault`, `--every`, `--duty` and `--times` are the
same as options:

| parameter | unit | range | default | |
|---|---|---|---|---|
)";

constexpr const char* kRules = R"(
Time is in ticks of 0.1 ms: a fault has its first effect in the tick that its acknowledgement names. Each pulse rises in
`ramp_s`, lasts for `for_s` from its start, and falls in `ramp_out_s`; what is said to act "at once" has no ramp. A
condition is looked at after each tick, on the truth, and starts the fault with the next one: at once if it is true
already, and again (`times`) once it has been false in between and the pulse is over. With `every_s` the trigger starts a
row of pulses. A quantity has its unit in its name: `x3_in`; a sensor's quantity may be named as its signal, `x3`. The same
`seed` gives the same random numbers at the same ticks, in real time, in lockstep and in a replay.

    servohil fault inject sensor_frozen signal=x3 --when 'x3_in > 5' for_s=2
    servohil fault inject tx_lost message=SERVO_Position probability=0.3 seed=7 --every 1 --duty 0.3 --times 5
    servohil fault inject supply_sag depth_psi=100 ramp_s=0.2 ramp_out_s=2 for_s=1 --when-frame 0x100

A fault is injected once for each target: an offset on x3 and one on p3 act together; the same one again replaces the
first. Faults combine; those that act on the same thing act in the order of this list, in whichever order they were
injected. What would have no effect as it is asked for is APPLIED with a warning that says so.

Sensor faults act between truth and frames: a recording's samples stay the truth, its `published` tables are what was
said, `fault_events` holds each start and end. An open wire has all bits of the signal's field 1, the highest raw value
(of a signed one -1): "signal not available", as J1939 has it. A snapshot is refused while `sensor_delayed` is injected;
frames on their way (`tx_delayed`, `rx_delayed`) are in none. In lockstep a command frame that is lost or late still lets
time pass: P1 is what is lost.

"Thesis": also with `model.physics = "thesis"`. Each effect has a number in `tests/fault`.
)";

std::string CommonRows() {
  std::string rows;
  for (const CommonParameter& p : CommonParameters()) {
    const std::string range = p.minimum == p.maximum ? "" : base::Formatted("%g to %g", p.minimum, p.maximum);
    const bool all = p.fits(fault::Spec{});
    rows += base::Formatted("| `%s` | %s | %s | %s | %s%s |\n", p.name, p.unit, range.c_str(), p.preset,
                            p.meaning, all ? "" : "; of some faults, see there");
  }
  return rows;
}

std::string ParameterRows(const fault::Spec& spec) {
  std::string rows;
  for (const fault::ParameterSpec& p : spec.parameters) {
    if (p.name == nullptr) break;
    rows += base::Formatted("| `%s` | %s | %g to %g | %g | %s |\n", p.name, p.unit, p.minimum, p.maximum,
                            p.preset, p.meaning);
  }
  return rows.empty() ? "" : "\n| parameter | unit | range | default | |\n|---|---|---|---|---|\n" + rows;
}

/// "Besides: `signal`, `seed`": what not every fault has.
std::string FurtherParameters(const fault::Spec& spec) {
  std::string names;
  for (const CommonParameter& p : CommonParameters()) {
    if (p.fits(spec) && !p.fits(fault::Spec{}))
      names += (names.empty() ? "`" : ", `") + std::string(p.name) + "`";
  }
  return names.empty() ? "" : "\nBesides: " + names + ".\n";
}

/// What the model must be, or the run have.
std::string Requirement(const fault::Spec& spec) {
  if (spec.part > fault::Part::kStabilizer) {
    const char* only = fault::OnlyWith(spec.needs);
    return only == nullptr || spec.needs == fault::Needs::kBus ? "" : std::string(" Only with ") + only + ".";
  }
  return spec.needs == fault::Needs::kFullPhysics  ? ""
         : spec.needs == fault::Needs::kStabilizer ? " Thesis. Only with stabilizer.enabled = true."
                                                   : " Thesis.";
}

/// tools/draw_faults.py draws it: not what no run of the default configuration has.
std::string Picture(const fault::Spec& spec) {
  if (spec.needs == fault::Needs::kCounter || spec.needs == fault::Needs::kChecksum ||
      spec.needs == fault::Needs::kErrorFrames)
    return {};
  return std::string("\n![") + spec.name + "](.github/pictures/faults/" + spec.name + ".png)\n";
}

}  // namespace

std::string ExampleLine(const fault::Spec& spec) {
  std::string line = std::string("servohil fault inject ") + spec.name;
  if (spec.HasSignal()) line += " signal=x3";
  for (const fault::ParameterSpec& p : spec.parameters) {
    if (p.name != nullptr) line += base::Formatted(" %s=%g", p.name, p.preset);
  }
  const bool has_ramp = !spec.varies && spec.part <= fault::Part::kStabilizer;
  return line + (has_ramp ? " ramp_s=0.5 for_s=3" : " for_s=3");
}

std::string FaultDocument() {
  std::string text = kHead + CommonRows() + kRules;
  const char* part = "";
  for (const fault::Spec& spec : fault::Catalogue()) {
    if (part != fault::NameOf(spec.part)) {
      part = fault::NameOf(spec.part);
      text += base::Formatted("\n## On the %s\n", part);
    }
    text += std::string("\n### ") + spec.name + "\n\n" + spec.effect + Requirement(spec) + "\n" +
            ParameterRows(spec) + FurtherParameters(spec) + "\n    " + ExampleLine(spec) + "\n" +
            Picture(spec);
  }
  return text;
}

}  // namespace servohil::fault_words
