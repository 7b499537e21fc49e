// Any FAULT_Request frames, one after the other: each asks the simulation for something sound, or is
// answered.

#include <algorithm>
#include <cmath>

#include "can/dbc/dbc.hpp"
#include "emulator/fault_port.hpp"
#include "fuzz.hpp"
#include "simulation/quantity.hpp"

namespace {

namespace can = servohil::can;
namespace fault = servohil::fault;

constexpr std::size_t kMessages = 6;

const can::Databases& Messages() {
  static const can::Databases databases = can::ReadDbcs({SERVOHIL_CONFIG_DIR "/servohil.dbc"});
  return databases;
}

servohil::emulator::FaultPort MakePort() {
  static const servohil::model::Parameters unfaulted;
  return {Messages(), {{&unfaulted}, true, kMessages, servohil::simulation::Quantities().size()}};
}

void RequireSound(const servohil::simulation::Request& request) {
  if (request.kind == servohil::simulation::Request::Kind::kClearAll) return;
  const fault::Injection& injection = request.injection;
  const fault::Spec* const spec = fault::Find(injection.id);
  Require(spec != nullptr, "the fault is of the catalogue");
  if (request.kind != servohil::simulation::Request::Kind::kInject) return;
  for (std::size_t i = 0; i < spec->parameters.size() && spec->parameters[i].name != nullptr; ++i) {
    const fault::ParameterSpec& p = spec->parameters[i];
    Require(injection.values[i] >= p.minimum && injection.values[i] <= p.maximum,
            "parameters are within their range");
  }
  Require(!spec->HasSignal() || injection.target < servohil::simulation::Quantities().size(),
          "a sensor's fault has a sensor");
}

/// What the simulation may say to it.
servohil::simulation::Answer AnswerTo(const servohil::simulation::Request& request) {
  constexpr unsigned kResults = 6;
  return {request.number,
          static_cast<servohil::simulation::Answer::Result>(request.injection.target % kResults), 1};
}

}  // namespace

int FuzzOne(std::string_view bytes) {
  servohil::emulator::FaultPort port = MakePort();
  can::Frame frame;
  can::Frame response;
  frame.id = servohil::emulator::FaultPort::RequestId(Messages()).id;
  constexpr std::size_t kSize = 8;
  for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), kSize))) {
    frame.size = static_cast<std::uint8_t>(std::min(bytes.size(), kSize));
    std::copy_n(bytes.begin(), frame.size, frame.data.begin());
    const auto request = port.Take(frame);
    const bool answered = port.TryPopResponse(response);
    Require(!request || !answered, "a request is not answered before the simulation has taken it");
    Require(request || answered || frame.size < kSize, "a whole request is taken or answered");
    if (!request) continue;
    RequireSound(*request);
    response = port.ResponseTo(AnswerTo(*request));
    Require(response.size == kSize, "a response has its size");
  }
  return 0;
}
