#include "configuration/envelope_check.hpp"

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "model/envelope_sweep.hpp"
#include "model/step.hpp"

namespace servohil::configuration {
namespace {

using model::Fastest;

const char* NameOf(Fastest fastest) {
  switch (fastest) {
    case Fastest::kRelayChamber:
      return "the chamber above the relay plunger";
    case Fastest::kPistonChamber:
      return "the chamber under the piston";
    case Fastest::kOilStiffness:
      return "oil at a cavity or at its dissolution pressure";
    case Fastest::kMeteringPorts:
      return "the plunger's sweep over the metering ports";
  }
  return "";
}

/// "KEY = VALUE" of what makes it slower.
std::string Remedy(Fastest fastest, const Configuration& c) {
  const model::ServoParameters& servo = c.model.servo;
  const auto key = [](const char* name, double value) { return base::Formatted("%s = %g", name, value); };
  switch (fastest) {
    case Fastest::kRelayChamber:
      return "raise " + key("servo.relay_volume_in3", servo.relay_volume_in3) + " or lower " +
             key("servo.relay_port_height_in", servo.relay_port_height_in) + " or " +
             key("servo.relay_port_width_in", servo.relay_port_width_in);
    case Fastest::kPistonChamber:
      return "raise " + key("servo.piston_volume_at_zero_in3", servo.piston_volume_at_zero_in3) +
             " or lower " + key("servo.metering_port_height_in", servo.metering_port_height_in);
    case Fastest::kOilStiffness:
      return "raise " + key("oil.air_fraction", c.model.oil.air_fraction) + " or lower " +
             key("servo.bulk_modulus_psi", servo.bulk_modulus_psi);
    case Fastest::kMeteringPorts:
      return "raise " + key("servo.main_spring_rate_lbf_in", servo.main_spring_rate_lbf_in) + " or lower " +
             key("servo.relay_port_height_in", servo.relay_port_height_in);
  }
  return "";
}

std::string Describe(const model::EnvelopeSweep& sweep, const Configuration& c) {
  const model::SweepTick& at = sweep.worst;
  const std::string numbers = base::Formatted(
      "at x3 = %.4g in, P3 = %.4g psi, P4 = %.4g psi under P1 = %.4g psi %s changes at %.3g 1/s: %.0f "
      "sub-steps of "
      "a tick wanted, %d allowed, ",
      at.state.x3_in, at.state.p3_psi, at.state.p4_psi, at.p1_psi, NameOf(at.fastest), at.rate_1_s, at.wanted,
      model::kMaxSubSteps);
  const std::string errors = sweep.left_domain
                                 ? "and the state leaves the model's domain"
                                 : base::Formatted("a pressure is wrong by up to %.3g psi, x3 by %.2g in",
                                                   sweep.pressure_error_psi, sweep.x3_error_in);
  return numbers + errors + "; " + Remedy(at.fastest, c);
}

}  // namespace

std::string CheckEnvelope(const Configuration& configuration, const model::Derived& derived) {
  const model::EnvelopeSweep sweep = model::SweepEnvelope(derived);
  if (sweep.Accurate(derived)) return "";
  if (derived.full) {
    throw base::UsageError("configuration not resolved between P1 = 0 and 300 psi: " +
                           Describe(sweep, configuration));
  }
  return "physics \"thesis\" is not resolved between P1 = 0 and 300 psi: " + Describe(sweep, configuration) +
         "; or model.physics = \"full\"";
}

}  // namespace servohil::configuration
