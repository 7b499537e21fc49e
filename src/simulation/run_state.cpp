#include "simulation/run_state.hpp"

namespace servohil::simulation {

const char* NameOf(Mode mode) {
  switch (mode) {
    case Mode::kWaiting:
      return "WAITING";
    case Mode::kRunning:
      return "RUNNING";
    case Mode::kModelFault:
      return "MODEL_FAULT";
    case Mode::kFrozen:
      return "FROZEN";
    case Mode::kDegraded:
      return "DEGRADED";
    case Mode::kTripped:
      return "TRIPPED";
    default:
      return "STOPPED";
  }
}

}  // namespace servohil::simulation
