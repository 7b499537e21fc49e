#include "servohil/app/contract.hpp"

#include <gtest/gtest.h>

#include "default_setup.hpp"
#include "servohil/can/codec.hpp"
#include "servohil/error.hpp"

namespace servohil::app {
namespace {

std::string ErrorOf(const std::string& dbc) {
  try {
    const Contract contract(can::ParseDbc(dbc, "test.dbc"), PublishSettings{0, 0, 0, 0, 0});
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Contract, EncodesAWorkedFrame) {
  const testing::DefaultSetup setup;
  Telemetry t;
  t.sample.tick = 0x01020304;
  t.sample.state.x3_in = 4.0;
  t.sample.state.v3_in_s = -1.5;
  const can::Frame frame = setup.contract.Encode(testing::kPosition, t);
  EXPECT_EQ(frame.id, 0x200U);
  EXPECT_FALSE(frame.extended);
  ASSERT_EQ(frame.size, 8);
  // X3: (4.0 + 1) / 0.0002 = 25000 = 0x61A8; V3: -1.5 / 0.01 = -150 = 0xFF6A; Tick as it is; all Intel.
  const std::array<std::uint8_t, 8> expected = {0xA8, 0x61, 0x6A, 0xFF, 0x04, 0x03, 0x02, 0x01};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(frame.data[i], expected[i]) << "byte " << i;
}

TEST(Contract, DecodesAWorkedCommand) {
  const testing::DefaultSetup setup;
  can::Frame frame;
  frame.id = 0x100;
  frame.size = 4;
  // P1 30.533 psi = 30533 raw = 0x07745 in bits 12 to 31; counter 3 in bits 8 to 11.
  frame.data = {0x00, 0x53, 0x74, 0x07};
  CommandRejection rejection{};
  const auto command = setup.contract.DecodeCommand(frame, rejection);
  ASSERT_TRUE(command);
  EXPECT_NEAR(command->p1_psi, 30.533, 1e-12);
}

TEST(Contract, TellsApartWhyAFrameIsNoCommand) {
  const testing::DefaultSetup setup;
  can::Frame frame;
  frame.id = 0x100;
  frame.size = 4;
  CommandRejection rejection{};
  can::Frame other = frame;
  other.id = 0x101;
  EXPECT_FALSE(setup.contract.DecodeCommand(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kUnknownId);
  other = frame;
  other.extended = true;
  EXPECT_FALSE(setup.contract.DecodeCommand(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kUnknownId) << "0x100 with 29 bits is another identifier";
  other = frame;
  other.size = 3;
  EXPECT_FALSE(setup.contract.DecodeCommand(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kMalformed);
  other = frame;
  other.remote = true;
  EXPECT_FALSE(setup.contract.DecodeCommand(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kMalformed);
  other = frame;
  other.data = {0, 0xF0, 0xFF, 0xFF};  // 1048.575 psi
  EXPECT_FALSE(setup.contract.DecodeCommand(other, rejection));
  EXPECT_EQ(rejection, CommandRejection::kOutOfRange);
}

TEST(Contract, HasTheResolutionThatWasPromised) {
  const can::Database dbc = can::ReadDbc(SERVOHIL_CONFIG_DIR "/servohil.dbc");
  for (const can::Message& message : dbc.messages) {
    for (const can::Signal& signal : message.signals) {
      if (signal.unit == "in") {
        EXPECT_LE(signal.factor, 0.0005) << signal.name;
      }
      if (signal.unit == "psi") {
        EXPECT_LE(signal.factor, 0.01) << signal.name;
      }
    }
  }
}

TEST(Contract, RefusesADbcThatDoesNotFit) {
  EXPECT_NE(ErrorOf("BO_ 1 GOV_Comand: 8 X\n").find("GOV_Command"), std::string::npos);
  EXPECT_NE(ErrorOf("BO_ 1 GOV_Command: 8 X\n SG_ P1_Demand : 0|16@1+ (1,0) [0|0] \"bar\" X\n")
                .find("test.dbc:2: GOV_Command.P1_Demand has the unit \"bar\", expected \"psi\""),
            std::string::npos);
  EXPECT_NE(ErrorOf("BO_ 1 GOV_Command: 8 X\n SG_ P1 : 0|16@1+ (1,0) [0|0] \"psi\" X\n").find("P1_Demand"),
            std::string::npos);
  EXPECT_EQ(ErrorOf("BO_ 1 GOV_Command: 8 X\n SG_ P1_Demand : 0|16@1+ (1,0) [0|0] \"psi\" X\n"), "no error");
}

}  // namespace
}  // namespace servohil::app
