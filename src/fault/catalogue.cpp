#include "fault/catalogue.hpp"

#include "fault/bus_faults.hpp"
#include "fault/oil_and_supply_faults.hpp"
#include "fault/piston_and_load_faults.hpp"
#include "fault/relay_faults.hpp"
#include "fault/sensor_faults.hpp"
#include "fault/stabilizer_faults.hpp"

namespace servohil::fault {
namespace {

template <std::size_t... kSizes>
constexpr auto Joined(const std::array<Spec, kSizes>&... parts) {
  std::array<Spec, (kSizes + ...)> all{};
  std::size_t next = 0;
  const auto append = [&](const auto& part) {
    for (const Spec& spec : part) all[next++] = spec;
  };
  (append(parts), ...);
  return all;
}

// Numbers stay for ever: recordings hold them. New faults take new ones. Those that act together act in the
// order of this table, in whichever order they were injected.
constexpr std::array kCatalogue = Joined(kOilAndSupplyFaults, kRelayFaults, kPistonAndLoadFaults,
                                         kStabilizerFaults, kSensorFaults, kBusFaults);

constexpr std::size_t kNumbers = 256;
constexpr std::uint8_t kNoFault = 255;
static_assert(kCatalogue.size() < kNoFault);

/// From a fault's number to its place.
constexpr std::array<std::uint8_t, kNumbers> kPlaces = [] {
  std::array<std::uint8_t, kNumbers> places{};
  places.fill(kNoFault);
  for (std::size_t i = 0; i < kCatalogue.size(); ++i) places[kCatalogue[i].id] = static_cast<std::uint8_t>(i);
  return places;
}();

}  // namespace

const char* NameOf(Part part) noexcept {
  static constexpr std::array kNames = {"oil",        "supply",  "relay", "piston",  "load",
                                        "stabilizer", "sensors", "bus",   "emulator"};
  return kNames[static_cast<std::size_t>(part)];
}

std::span<const Spec> Catalogue() noexcept {
  return kCatalogue;
}

const Spec* Find(std::uint8_t id) noexcept {
  return kPlaces[id] == kNoFault ? nullptr : &kCatalogue[kPlaces[id]];
}

const char* OnlyWith(Needs needs) noexcept {
  switch (needs) {
    case Needs::kNothing:
      break;
    case Needs::kFullPhysics:
      return "model.physics = \"full\"";
    case Needs::kStabilizer:
      return "stabilizer.enabled = true";
    case Needs::kBus:
      return "a bus: servohil run";
    case Needs::kCounter:
      return "a published message with a counter: e2e in [[can.publish]]";
    case Needs::kChecksum:
      return "a published message with a checksum: e2e in [[can.publish]]";
    case Needs::kErrorFrames:
      return "vcan, which carries error frames";
    case Needs::kRealTime:
      return "a run in real time";
  }
  return nullptr;
}

const char* Unsupported(const Spec& spec, const Surroundings& surroundings) noexcept {
  switch (spec.needs) {
    case Needs::kNothing:
      return nullptr;
    case Needs::kFullPhysics:
      return surroundings.unfaulted->physics == model::Physics::kFull
                 ? nullptr
                 : "model.physics = \"thesis\" does not have what it acts on";
    case Needs::kStabilizer:
      return surroundings.unfaulted->stabilizer.enabled ? nullptr : "stabilizer.enabled is false";
    case Needs::kBus:
      return surroundings.has_bus ? nullptr : "this run has no bus";
    case Needs::kCounter:
      return surroundings.counter ? nullptr
                                  : "no published message has a counter: set e2e in [[can.publish]]";
    case Needs::kChecksum:
      return surroundings.checksum ? nullptr
                                   : "no published message has a checksum: set e2e in [[can.publish]]";
    case Needs::kErrorFrames:
      return surroundings.has_bus ? surroundings.why_no_error_frames : "this run has no bus";
    case Needs::kRealTime:
      return surroundings.real_time ? nullptr : "no tick can be late: this run is not in real time";
  }
  return nullptr;
}

}  // namespace servohil::fault
