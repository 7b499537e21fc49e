#pragma once
/// From JSON requests to what the simulation is asked, and back: the words of the control socket.
/// PROTOCOL.md has the protocol.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "fault_words/permissions.hpp"
#include "simulation/request.hpp"
#include "simulation/run_state.hpp"

namespace servohil::control {

/// What is asked of the state.
enum class Question : std::uint8_t { kStatus, kStatistics, kFaults, kCatalogue };

/// Samples that a client wants.
struct Subscription {
  std::uint64_t every_ticks = 0;        ///< at the ticks that this divides; 0: none
  std::vector<std::size_t> quantities;  ///< as numbers in Quantities()
};

/// A request that the simulation must answer, a question, a subscription, or an answer at once.
using Understood = std::variant<simulation::Request, Question, Subscription, nlohmann::json>;

struct RequestLine {
  std::string id;  ///< as JSON; "null": none
  Understood asks;
  std::string warning = {};  ///< for the answer; empty: none
};

/// What a line asks. Never throws: what is wrong is the answer.
RequestLine Understand(std::string_view line, const fault_words::Permissions& permissions);

/// The answer as a line, with its LF.
std::string AnswerLine(const std::string& id, const nlohmann::json& answer);

/// A sample as a line. @param dropped  how many of this subscription were lost since it began
std::string SampleLine(const std::string& id, const Subscription& subscription,
                       const simulation::RunState& now, std::uint64_t dropped);

/// Answers, without "id".
nlohmann::json Rejected(const std::string& reason);
nlohmann::json ToJson(const simulation::Answer& answer);
nlohmann::json FaultsToJson(const fault::Schedule& faults, std::uint64_t tick,
                            const fault_words::FaultContext& context);
nlohmann::json CatalogueToJson(const fault::Surroundings& surroundings);

}  // namespace servohil::control
