#include "run/permission.hpp"

namespace servohil::run {

fault_words::FaultContext FaultContextOf(const RunSetup& setup, const can::Network& network,
                                         const std::vector<can::WantedId>& received, emulator::Clock clock) {
  fault_words::FaultContext context;
  context.signal_map = &setup.signal_map;
  context.surroundings.unfaulted = &setup.configuration.model;
  context.surroundings.real_time = clock == emulator::Clock::kReal;
  context.surroundings.counter = setup.signal_map.AnyPublished([](const can::E2eLayout&) { return true; });
  context.surroundings.checksum = setup.signal_map.AnyPublished(can::HasChecksum);
  for (const auto& bus : network.Buses()) {
    const char* why = bus->WhyNoErrorFrames();
    if (why != nullptr) context.surroundings.why_no_error_frames = why;
    if (!bus->Interface().empty()) context.received = received;
  }
  return context;
}

fault_words::Permissions PermissionsOf(const configuration::Configuration& configuration,
                                       const fault_words::FaultContext& context,
                                       const can::Network& network) {
  fault_words::Permissions permissions{context, configuration.fault.armed == configuration::Armed::kYes, {}};
  if (permissions.armed) return permissions;
  if (configuration.fault.armed == configuration::Armed::kNo) {
    permissions.why_not_armed = "faults are not armed: fault.armed = \"no\"";
    return permissions;
  }
  for (const auto& bus : network.Buses()) {
    if (bus->IsVirtual()) continue;
    permissions.why_not_armed = "faults are not armed: " + bus->Name() +
                                " may be physical; --set fault.armed=yes if it may be disturbed";
    return permissions;
  }
  permissions.armed = true;
  return permissions;
}

}  // namespace servohil::run
