// The value tables of FAULT_Request and FAULT_Response in config/servohil.dbc are those of the program.

#include "emulator/fault_port.hpp"

#include <gtest/gtest.h>

#include "can/dbc/dbc.hpp"
#include "simulation/quantity.hpp"
#include "support/paths.hpp"

namespace servohil::emulator {
namespace {

const can::Message& MessageNamed(const char* name) {
  static const can::Database database = can::ReadDbc(testing::ConfigFile("servohil.dbc"));
  return database.RequireMessage(name);
}

const std::map<std::int64_t, std::string>& ValueNames(const char* message, const char* signal) {
  return MessageNamed(message).FindSignal(signal)->value_names;
}

TEST(FaultMessages, NameEveryFaultOfTheCatalogue) {
  std::map<std::int64_t, std::string> expected;
  for (const fault::Spec& spec : fault::Catalogue()) expected[spec.id] = spec.name;
  std::string line = "VAL_ 257 Fault ";
  for (const auto& [id, name] : expected) line += std::to_string(id) + " \"" + name + "\" ";
  EXPECT_EQ(ValueNames("FAULT_Request", "Fault"), expected) << "the right line: " << line << ";";
}

TEST(FaultMessages, NameTheTargetsThatSensorsMeasure) {
  for (const auto& [index, name] : ValueNames("FAULT_Request", "Target")) {
    if (index == fault::Injection::kEverything) continue;
    ASSERT_LT(static_cast<std::size_t>(index), simulation::Quantities().size());
    EXPECT_EQ(name, simulation::Quantities()[static_cast<std::size_t>(index)].name);
  }
}

TEST(FaultMessages, NameResultsAndReasonsAsTheyAreSent) {
  using R = FaultReason;
  const auto& reasons = ValueNames("FAULT_Response", "Reason");
  EXPECT_EQ(reasons.size(), 11U);
  EXPECT_EQ(reasons.at(static_cast<int>(R::kOutOfRange)), "OUT_OF_RANGE");
  EXPECT_EQ(reasons.at(static_cast<int>(R::kUnknownTarget)), "UNKNOWN_TARGET");
  EXPECT_EQ(reasons.at(static_cast<int>(R::kNotInThisRun)), "NOT_IN_THIS_RUN");
  EXPECT_EQ(ValueNames("FAULT_Response", "Result").at(static_cast<int>(FaultResult::kSet)), "SET");
}

TEST(FaultPort, TellsWhatItsMessagesLack) {
  can::Databases databases{{can::ReadDbc(testing::ConfigFile("servohil.dbc"))}};
  for (can::Message& message : databases.files.front().messages) {
    if (message.name != "FAULT_Request") continue;
    std::erase_if(message.signals, [](const can::Signal& signal) { return signal.name == "Value"; });
  }
  try {
    const FaultPort port(databases, {});
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_STREQ(
        error.what(),
        "fault.allow_can = true: message FAULT_Request has no signal Value (config/servohil.dbc has it)");
  }
}

}  // namespace
}  // namespace servohil::emulator
