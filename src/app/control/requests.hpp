#pragma once
/// From JSON requests to what the simulation is asked, and back: the words of the control socket.
/// PROTOCOL.md has the protocol.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "../injection_words.hpp"
#include "servohil/app/request.hpp"

namespace servohil::app::control {

/// Whoever may ask for what.
struct Permissions {
  FaultContext faults;
  bool armed;  ///< faults may be injected
  std::string why_not_armed;
};

/// A request that the simulation must answer; or an answer at once; `status` and `faults` need the state.
enum class Question : std::uint8_t { kStatus, kFaults, kCatalogue };
using Understood = std::variant<Request, Question, nlohmann::json>;

struct RequestLine {
  std::string id;  ///< as JSON; "null": none
  Understood asks;
  std::string warning = {};  ///< for the answer; empty: none
};

/// What a line asks. Never throws: what is wrong is the answer.
RequestLine Understand(std::string_view line, const Permissions& permissions);

/// The answer as a line, with its LF.
std::string AnswerLine(const std::string& id, const nlohmann::json& answer);

/// Answers, without "id".
nlohmann::json Rejected(const std::string& reason);
nlohmann::json ToJson(const Answer& answer);
nlohmann::json FaultsToJson(const fault::Schedule& faults, std::uint64_t tick, const FaultContext& context);
nlohmann::json CatalogueToJson(const fault::Surroundings& surroundings);

}  // namespace servohil::app::control
