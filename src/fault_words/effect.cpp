#include "fault_words/effect.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include "simulation/quantity.hpp"

namespace servohil::fault_words {
namespace {

using fault::Random;
using fault::Values;

// A moment at which a fault that varies is not by chance where the unfaulted model is.
constexpr double kSomeTimeS = 0.0123;

bool Changes(fault::ParameterAct act, const Values& values, const FaultContext& context) {
  model::Parameters faulted = *context.surroundings.unfaulted;
  act(faulted, values, 1.0, kSomeTimeS);
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): an unchanged copy has the same bits
  return std::memcmp(&faulted, context.surroundings.unfaulted, sizeof faulted) != 0;
}
bool Changes(fault::SensorAct act, const Values& values, const FaultContext&) {
  fault::Reading reading{.value = 1.2345, .held = 1.0, .delayed = 1.1, .t_s = kSomeTimeS};
  Random random(0, 0, 0, 0);
  const double truth = reading.value;
  act(reading, values, 1.0, random);
  return reading.value != truth;  // not a number is a change
}
bool Changes(fault::TransmitAct act, const Values& values, const FaultContext&) {
  fault::Transmission fate;
  Random random(0, 0, 0, 0);
  act(fate, values, 1.0, random);
  return fate != fault::Transmission{};
}
bool Changes(fault::ReceiveAct act, const Values& values, const FaultContext&) {
  fault::Reception fate;
  Random random(0, 0, 0, 0);
  act(fate, values, 1.0, random);
  return fate != fault::Reception{};
}
bool Changes(fault::LineAct act, const Values& values, const FaultContext&) {
  fault::Line line;
  act(line, values, 1.0);
  return line.down || line.babble_hz > 0.0 || line.errors_hz > 0.0;
}
bool Changes(fault::StallAct, const Values&, const FaultContext&) {
  return true;
}

/// The chance that it hits, where it has one; else 1.
double Probability(const fault::Spec& spec, const Values& values) {
  for (std::size_t i = 0; i < spec.parameters.size() && spec.parameters[i].name != nullptr; ++i) {
    if (std::string_view(spec.parameters[i].name) == "probability") return values[i];
  }
  return 1.0;
}

}  // namespace

std::string WhyNoEffect(const fault::Spec& spec, const fault::Injection& injection,
                        const FaultContext& context) {
  const double probability = Probability(spec, injection.values);
  if (probability == 0.0) return "no effect: probability = 0";
  const bool changes =
      std::visit([&](auto act) { return Changes(act, injection.values, context); }, spec.act);
  if (!changes && probability == 1.0) return "no effect: with these values all stays what it is";
  if (!spec.HasSignal() || context.signal_map == nullptr) return {};
  const simulation::Quantity& quantity = simulation::Quantities()[injection.target];
  if (context.signal_map->MessagesCarrying(quantity.name) != 0) return {};
  return std::string("no effect: no published message carries ") + quantity.name;
}

}  // namespace servohil::fault_words
