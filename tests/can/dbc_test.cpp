#include "servohil/can/dbc.hpp"

#include <gtest/gtest.h>

#include <string>

#include "servohil/error.hpp"

namespace servohil::can {
namespace {

const std::string kHeader = "VERSION \"\"\nNS_ :\n  CM_\n  BA_DEF_\nBS_:\nBU_: A B\n";  // six lines

std::string ErrorOf(const std::string& text) {
  try {
    ParseDbc(text, "x.dbc");
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no error";
}

/// One message of 8 bytes in line 7 with this signal in line 8.
std::string WithSignal(const std::string& signal) {
  return kHeader + "BO_ 1 M: 8 A\n " + signal + "\n";
}

TEST(Dbc, ReadsMessageAndSignal) {
  const Database database = ParseDbc(
      kHeader + "BO_ 2566844672 Ext : 8 A\n SG_ S : 7|12@0- (-0.5,+1E+1) [-1.5e3|2000] \"rpm\" A, B\n",
      "x.dbc");
  ASSERT_EQ(database.messages.size(), 1U);
  const Message& message = database.messages[0];
  EXPECT_EQ(message.name, "Ext");
  EXPECT_EQ(message.id, 2566844672 - 0x8000'0000);
  EXPECT_TRUE(message.extended);
  EXPECT_EQ(message.sender, "A");
  EXPECT_EQ(message.line, 7);
  const Signal& signal = database.RequireSignal(message, "S");
  EXPECT_EQ(signal.start_bit, 7);
  EXPECT_EQ(signal.length_bits, 12);
  EXPECT_FALSE(signal.little_endian);
  EXPECT_TRUE(signal.is_signed);
  EXPECT_EQ(signal.factor, -0.5);
  EXPECT_EQ(signal.offset, 10.0);
  EXPECT_EQ(signal.minimum, -1500.0);
  EXPECT_EQ(signal.maximum, 2000.0);
  EXPECT_EQ(signal.unit, "rpm");
  EXPECT_EQ(signal.line, 8);
}

TEST(Dbc, StringsGoOverLinesAndHaveEscapes) {
  const Database database = ParseDbc(
      WithSignal("SG_ S : 0|8@1+ (1,0) [0|0] \"\" A") +
          "CM_ SG_ 1 S \"one;\r\n\\\"two\\\" BO_ 1\";\r\nCM_ BO_ 1 \"m\";\nVAL_ 1 S 0 \"off\" -1 \"?\" ;\n"
          "BO_ 2 Next: 1 B\n",
      "x.dbc");
  const Signal& signal = database.messages[0].signals[0];
  EXPECT_EQ(signal.comment, "one;\n\"two\" BO_ 1");
  EXPECT_EQ(database.messages[0].comment, "m");
  EXPECT_EQ(signal.value_names.at(0), "off");
  EXPECT_EQ(signal.value_names.at(-1), "?");
  EXPECT_EQ(database.messages[1].line, 13);  // the string's line break is counted
}

TEST(Dbc, SkipsWhatANodeDoesNotNeed) {
  const Database database = ParseDbc(
      WithSignal("SG_ S : 0|8@1+ (1,0) [0|0] \"\" Vector__XXX") +
          "BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX\n SG_ Lost : 0|8@1+ (1,0) [0|0] \"\" A\n"
          "BO_TX_BU_ 1 : A,B;\nEV_ Env: 0 [0|1] \"\" 0 3 DUMMY_NODE_VECTOR0 A;\nVAL_ Env 1 \"on\" 0 \"off\" "
          ";\n"
          "VAL_TABLE_ T 1 \"a;\" 0 \"b\" ;\nBA_DEF_ BO_ \"Cycle\" INT 0 100;\nBA_DEF_DEF_ \"Cycle\" 10;\n"
          "BA_ \"Cycle\" BO_ 1 20;\nSIG_GROUP_ 1 G 1 : S;\nCM_ \"all\";\nCM_ EV_ Env \"e\";\nCM_ BU_ A "
          "\"a\";\n"
          "CM_ SG_ 1 Gone \"left over\";\nCM_ BO_ 99 \"left over\";\nSOMETHING_NEW_ 1 2 \"three\";\n",
      "x.dbc");
  ASSERT_EQ(database.messages.size(), 1U);
  EXPECT_EQ(database.messages[0].signals.size(), 1U);
}

TEST(Dbc, ReadsLatin1AsUtf8) {
  EXPECT_EQ(ParseDbc(WithSignal("SG_ T : 0|8@1+ (1,0) [0|0] \"\xB0"
                                "C\" A"),
                     "x.dbc")
                .messages[0]
                .signals[0]
                .unit,
            "\xC2\xB0"
            "C");
}

TEST(Dbc, KeepsUtf8AndSkipsItsByteOrderMark) {
  EXPECT_EQ(ParseDbc("\xEF\xBB\xBF" + WithSignal("SG_ T : 0|8@1+ (1,0) [0|0] \"\xC2\xB0"
                                                 "C\" A"),
                     "x.dbc")
                .messages[0]
                .signals[0]
                .unit,
            "\xC2\xB0"
            "C");
}

TEST(Dbc, SaysWhereAndWhatItExpected) {
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S 0|8@1+ (1,0) [0|0] \"\" A")),
            "x.dbc:8: expected ':' after the signal's name, found '0'");
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|65@1+ (1,0) [0|0] \"\" A")),
            "x.dbc:8: expected the signal's length in bits (1 to 64), found '65'");
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|8@2+ (1,0) [0|0] \"\" A")),
            "x.dbc:8: expected the byte order: 0 (Motorola) or 1 (Intel) (0 to 1), found '2'");
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|8@1 (1,0) [0|0] \"\" A")),
            "x.dbc:8: expected '+' (unsigned) or '-' (signed), found '('");
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|8@1+ (0,0) [0|0] \"\" A")),
            "x.dbc:8: expected a factor, found 0 in signal 'S'");
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|8@1+ (1,0) [0|0] \"psi A")),
            "x.dbc:8: this string has no closing '\"'");
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|8@1+ (1x,0) [0|0] \"psi\" A")),
            "x.dbc:8: '1x' is neither a number nor a name");
  EXPECT_EQ(ErrorOf(kHeader + "BO_ 1 M: 8"),
            "x.dbc:7: expected the message's sender, found the end of the file");
  EXPECT_EQ(ErrorOf(kHeader + "BOO_ 1 M: 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" A\n"),
            "x.dbc:7: expected a statement with ';' at its end, found 'BOO_' and then 'SG_'");
  EXPECT_EQ(ErrorOf("SG_ S : 0|8@1+ (1,0) [0|0] \"\" A"),
            "x.dbc:1: found SG_ outside a message: expected BO_ before it");
  EXPECT_EQ(
      ErrorOf("garbage"),
      "x.dbc:1: expected a statement with ';' at its end, found 'garbage' and then the end of the file");
}

TEST(Dbc, RefusesSignalsThatDoNotFit) {
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 60|8@1+ (1,0) [0|0] \"\" A")),
            "x.dbc:8: signal 'S' (60|8@1) reaches beyond the 8 bytes of message 'M'");
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 56|9@0+ (1,0) [0|0] \"\" A")),
            "x.dbc:8: signal 'S' (56|9@0) reaches beyond the 8 bytes of message 'M'");
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 56|8@1+ (1,0) [0|0] \"\" A")), "no error");
}

TEST(Dbc, RefusesOverlapUnlessMultiplexed) {
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|12@1+ (1,0) [0|0] \"\" A\n SG_ T : 15|8@0+ (1,0) [0|0] \"\" A")),
            "x.dbc:9: signal 'T' (15|8@0) overlaps signal 'S' of line 8 in byte 1");
  EXPECT_EQ(
      ErrorOf(WithSignal("SG_ S m0 : 0|12@1+ (1,0) [0|0] \"\" A\n SG_ T m1 : 15|8@0+ (1,0) [0|0] \"\" A")),
      "no error");
}

TEST(Dbc, RefusesNamesAndIdsThatAreThereTwice) {
  EXPECT_EQ(ErrorOf(kHeader + "BO_ 1 M: 8 A\nBO_ 2 M: 8 A\n"),
            "x.dbc:8: message 'M' is there twice, first in line 7");
  EXPECT_EQ(ErrorOf(kHeader + "BO_ 1 M: 8 A\nBO_ 1 N: 8 A\n"),
            "x.dbc:8: message 'N' has the id 1 of 'M' in line 7");
  EXPECT_EQ(ErrorOf(kHeader + "BO_ 1 M: 8 A\nBO_ 2147483649 N: 8 A\n"), "no error");  // 29-bit id 1
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|8@1+ (1,0) [0|0] \"\" A\n SG_ S : 8|8@1+ (1,0) [0|0] \"\" A")),
            "x.dbc:9: signal 'S' is there twice, first in line 8");
}

TEST(Dbc, RefusesIdsOfTooManyBits) {
  EXPECT_EQ(ErrorOf(kHeader + "BO_ 2048 M: 8 A\n"),
            "x.dbc:7: message 'M' has the id 2048, expected at most 2047 (29-bit ids have bit 31 set: add "
            "2147483648)");
  EXPECT_EQ(ErrorOf(kHeader + "BO_ 2684354560 M: 8 A\n"),  // bits 31 and 29
            "x.dbc:7: message 'M' has the id 536870912, expected at most 536870911");
}

std::string RefusalOf(const Database& database, const std::string& message) {
  try {
    database.RequireMessage(message);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Dbc, RequireRefusesWhatIsNotSupportedOnlyWhereItIsUsed) {
  const Database database = ParseDbc(
      kHeader +
          "BO_ 1 Muxed: 8 A\n SG_ Which M : 0|8@1+ (1,0) [0|0] \"\" A\n SG_ One m0 : 8|8@1+ (1,0) [0|0] \"\" "
          "A\n"
          "BO_ 2 Floats: 8 A\n SG_ F : 0|32@1- (1,0) [0|0] \"\" A\nBO_ 3 Long: 100 A\nBO_ 4 Plain: 8 A\n"
          "SIG_VALTYPE_ 2 F : 1;\n",
      "x.dbc");
  EXPECT_EQ(RefusalOf(database, "Muxed"),
            "x.dbc:8: message 'Muxed' has the multiplexed signal 'Which': multiplexing is not supported");
  EXPECT_EQ(RefusalOf(database, "Floats"),
            "x.dbc:11: message 'Floats' has the floating-point signal 'F' (SIG_VALTYPE_): only integers with "
            "factor and offset are supported");
  EXPECT_EQ(RefusalOf(database, "Long"), "x.dbc:12: message 'Long' has 100 bytes; a CAN FD frame holds 64");
  EXPECT_EQ(RefusalOf(database, "Plain"), "no error");
}

TEST(Dbc, SuggestsTheNearestName) {
  const Database database = ParseDbc(WithSignal("SG_ Pressure : 0|8@1+ (1,0) [0|0] \"\" A"), "x.dbc");
  EXPECT_EQ(RefusalOf(database, "Nothing"), "x.dbc: no message 'Nothing'; there are 1: M");
  try {
    database.RequireSignal(database.messages[0], "Presure");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "x.dbc:7: message 'M' has no signal 'Presure'; the nearest is 'Pressure'");
  }
}

TEST(Dbc, AFileThatIsNotThereIsAUsageError) {
  EXPECT_THROW(ReadDbc("/nowhere/x.dbc"), UsageError);
  EXPECT_THROW(ReadDbc("/tmp"), UsageError);
}

TEST(Dbc, NoPrefixOfAFileMakesItCrash) {
  const std::string whole = WithSignal("SG_ S m1M : 0|8@1+ (1.5e+3,-.5) [0|0] \"x\\\"\" A,B") +
                            "CM_ SG_ 1 S \"c\";\nVAL_ 1 S 1 \"a\" ;\nSIG_VALTYPE_ 1 S : 2;\n";
  for (std::size_t size = 0; size <= whole.size(); ++size) ErrorOf(whole.substr(0, size));
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const char c : {'"', '\0', ':', '9', 'x', '\n', '\xFF'}) {
      std::string damaged = whole;
      damaged[at] = c;
      ErrorOf(damaged);
    }
  }
}

}  // namespace
}  // namespace servohil::can
