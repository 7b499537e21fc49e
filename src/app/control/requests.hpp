#pragma once
/// From JSON requests to what the simulation is asked, and back: the words of the control socket.
/// PROTOCOL.md has the protocol.

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>

#include "../bus_watch.hpp"
#include "servohil/app/request.hpp"
#include "servohil/app/telemetry.hpp"
#include "servohil/model/parameters.hpp"

namespace servohil::app::control {

/// Whoever may ask for what.
struct Permissions {
  const model::Parameters* unfaulted;  ///< what the model has
  bool armed;                          ///< faults may be injected
  std::string why_not_armed;
};

/// A request that the simulation must answer; or an answer at once; `status` and `faults` need the state.
enum class Question : std::uint8_t { kStatus, kFaults, kCatalogue };
using Understood = std::variant<Request, Question, nlohmann::json>;

/// What a request line asks. Never throws: what is wrong is the answer.
Understood Understand(const nlohmann::json& request, const Permissions& permissions);

/// Answers, without "id".
nlohmann::json Rejected(const std::string& reason);
nlohmann::json ToJson(const Answer& answer);
nlohmann::json StatusToJson(const Telemetry& now, const std::vector<BusReport>& buses);
nlohmann::json BusesToJson(const std::vector<BusReport>& buses);
nlohmann::json FaultsToJson(const fault::Schedule& faults, std::uint64_t tick);
nlohmann::json CatalogueToJson(const model::Parameters& unfaulted);

}  // namespace servohil::app::control
