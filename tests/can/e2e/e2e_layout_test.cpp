#include <gtest/gtest.h>

#include <array>
#include <string>

#include "base/error.hpp"
#include "can/dbc/dbc.hpp"
#include "can/e2e/e2e.hpp"

namespace servohil::can {
namespace {

const Database kDatabase = ParseDbc(R"(
BU_: A B
BO_ 256 CMD: 8 A
 SG_ Value : 16|16@1+ (1,0) [0|0] "" B
 SG_ Counter : 7|4@0+ (1,0) [0|14] "" B
 SG_ Short : 0|3@1+ (1,0) [0|5] "" B
 SG_ Checksum : 63|8@0+ (1,0) [0|255] "" B
 SG_ Wide : 36|8@1+ (1,0) [0|255] "" B
BO_ 257 TAKEN: 2 A
 SG_ Value : 4|8@1+ (1,0) [0|0] "" B
)",
                                    "test.dbc");

const Signal* SignalOf(const char* name) {
  return kDatabase.RequireMessage("CMD").FindSignal(name);
}

std::string Refusal(const E2eSettings& settings, const char* message = "CMD") {
  try {
    MakeE2eLayout(settings, kDatabase.RequireMessage(message));
  } catch (const base::UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(E2eLayout, FollowsTheSignalsOfTheDbc) {
  const E2eLayout layout = MakeE2eLayout(
      {E2eProfile::kCrc8J1850, kNoDataId, DataIdMode::kBoth, SignalOf("Counter"), SignalOf("Checksum")},
      kDatabase.RequireMessage("CMD"));
  EXPECT_EQ(layout.modulus, 15U) << "0 to 14, as the DBC says";
  std::array<std::uint8_t, 8> data{};
  Protect(layout, 256, 0xA, data);
  EXPECT_EQ(data[0], 0xA0) << "Motorola, from bit 7 down";
  EXPECT_EQ(data[7], Crc8J1850({data.data(), 7}));
}

TEST(E2eLayout, ACounterGoesRoundWhereTheDbcSaysIt) {
  const auto modulus = [](const char* counter) {
    return MakeE2eLayout({E2eProfile::kCounter, kNoDataId, DataIdMode::kBoth, SignalOf(counter), nullptr},
                         kDatabase.RequireMessage("CMD"))
        .modulus;
  };
  EXPECT_EQ(modulus("Short"), 6U);
  EXPECT_EQ(modulus("Counter"), 15U);
}

TEST(E2eLayout, MistakesAreNamed) {
  using P = E2eProfile;
  const Signal* counter = SignalOf("Counter");
  const Signal* checksum = SignalOf("Checksum");
  EXPECT_EQ(Refusal({P::kAutosarP1, kNoDataId, DataIdMode::kBoth, counter, checksum}),
            "CMD: e2e = \"autosar_p1\" needs a Data ID: data_id = 0 to 65535");
  EXPECT_EQ(Refusal({P::kAutosarP11, 1, DataIdMode::kAlt, counter, checksum}),
            "CMD: e2e = \"autosar_p11\" takes the Data ID as \"both\" or \"nibble\"");
  EXPECT_EQ(Refusal({P::kAutosarP11, 0x1000, DataIdMode::kNibble, counter, checksum}),
            "CMD: e2e = \"autosar_p11\" has a Data ID of 4096, expected 0 to 4095");
  EXPECT_EQ(Refusal({P::kCounter, 1, DataIdMode::kBoth, counter, nullptr}),
            "CMD: e2e = \"counter\" has no Data ID: leave data_id out");
  EXPECT_EQ(Refusal({P::kCrc8J1850, kNoDataId, DataIdMode::kBoth, counter, SignalOf("Wide")}),
            "CMD: e2e = \"crc8_j1850\" has the checksum within one byte; the signal Wide does not lie so");
  EXPECT_EQ(Refusal({P::kAutosarP1, 1, DataIdMode::kBoth, SignalOf("Short"), checksum}),
            "CMD: e2e = \"autosar_p1\" has a counter of 4 bits at bit 0 or 4 of a byte, not of 3 at bit 0");
  EXPECT_EQ(Refusal({P::kCrc8J1850, kNoDataId, DataIdMode::kBoth, counter, SignalOf("Short")}),
            "CMD: e2e = \"crc8_j1850\" has a checksum of 8 bits, not of 3");
  EXPECT_EQ(
      Refusal({P::kCrc8J1850, kNoDataId, DataIdMode::kBoth, counter, nullptr}),
      "CMD: e2e = \"crc8_j1850\" needs bits 0 to 7 for the checksum, where the signal Counter lies: name the "
      "signal if it is meant, counter = or checksum =");
  EXPECT_EQ(Refusal({P::kAutosarP1, 1, DataIdMode::kNibble, counter, checksum}),
            "CMD: e2e = \"autosar_p1\" needs bits 0 to 3 for the Data ID's nibble, where the signal Short "
            "lies: name "
            "the signal if it is meant, counter = or checksum =");
  EXPECT_EQ(
      Refusal({P::kJ1939CounterChecksum, kNoDataId, DataIdMode::kBoth, nullptr, nullptr}, "TAKEN"),
      "TAKEN: e2e = \"j1939_counter_checksum\" needs bits 56 to 59 for the counter: the message has 2 bytes");
}

TEST(E2eLayout, WithoutAProfileNothingIsAskedOfTheMessage) {
  EXPECT_EQ(Refusal({}, "TAKEN"), "");
}

}  // namespace
}  // namespace servohil::can
