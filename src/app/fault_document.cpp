#include "fault_document.hpp"

#include "formatted.hpp"
#include "servohil/fault/catalogue.hpp"

namespace servohil::app {
namespace {

constexpr const char* kHead = R"(# Faults

<!-- `servohil fault list --markdown` writes this file from the catalogue; a test compares them. -->

What can be injected into a running servomotor: `servohil fault inject NAME PARAMETER=VALUE ...`. Every fault also has

| parameter | unit | range | default | |
|---|---|---|---|---|
| `at_s` | s | 0 to 1e+06 | now | simulated time at which it starts; `--at` is the same |
| `ramp_s` | s | 0 to 1e+06 | 0 | rises in this time, and falls again in as long at its end |
| `for_s` | s | 0 to 1e+06 | until cleared | from start to the beginning of its fall |

Faults combine; those that act on the same thing act in the order of this list, in whichever order they were injected.
"Thesis": also with `model.physics = "thesis"`; the others need `"full"`, the default. Those of the stabilizer need
`stabilizer.enabled = true`. Each effect has a number in `tests/fault/effect_test.cpp`.
)";

std::string ParameterRows(const fault::Spec& spec) {
  std::string rows;
  for (const fault::ParameterSpec& p : spec.parameters) {
    if (p.name == nullptr) break;
    rows += Formatted("| `%s` | %s | %g to %g | %g | %s |\n", p.name, p.unit, p.minimum, p.maximum, p.preset,
                      p.meaning);
  }
  return rows.empty() ? "" : "\n| parameter | unit | range | default | |\n|---|---|---|---|---|\n" + rows;
}

}  // namespace

std::string FaultDocument() {
  std::string text = kHead;
  const char* part = "";
  for (const fault::Spec& spec : fault::Catalogue()) {
    if (part != fault::NameOf(spec.part)) {
      part = fault::NameOf(spec.part);
      text += Formatted("\n## On the %s\n", part);
    }
    text += std::string("\n### ") + spec.name + "\n\n" + spec.effect +
            (spec.needs == fault::Needs::kFullPhysics ? "\n" : " Thesis.\n") + ParameterRows(spec) +
            "\n    servohil fault inject " + spec.name;
    for (const fault::ParameterSpec& p : spec.parameters) {
      if (p.name != nullptr) text += Formatted(" %s=%g", p.name, p.preset);
    }
    text += spec.varies ? " for_s=3\n" : " ramp_s=0.5 for_s=3\n";
  }
  return text;
}

}  // namespace servohil::app
