#include "can/dbc/dbc.hpp"

#include <gtest/gtest.h>

#include <string>

#include "base/error.hpp"

namespace servohil::can {
namespace {

const std::string kHeader = "VERSION \"\"\nNS_ :\n  CM_\n  BA_DEF_\nBS_:\nBU_: A B\n";  // six lines

std::string ErrorOf(const std::string& text) {
  try {
    ParseDbc(text, "x.dbc");
  } catch (const base::UsageError& error) {
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
            "x.dbc:8: the factor of signal 'S' is 0 (decimals have a point, no comma)");
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

TEST(Dbc, RefusesOverlapOfSignalsThatAFrameCanHaveTogether) {
  const auto two = [](const std::string& first, const std::string& second) {
    return ErrorOf(WithSignal("SG_ Which M : 63|1@1+ (1,0) [0|0] \"\" A\n SG_ S " + first +
                              ": 0|12@1+ (1,0) [0|0] \"\" A\n SG_ T " + second +
                              ": 15|8@0+ (1,0) [0|0] \"\" A"));
  };
  const std::string overlap = "x.dbc:10: signal 'T' (15|8@0) overlaps signal 'S' of line 9 in byte 1";
  EXPECT_EQ(two("", ""), overlap);
  EXPECT_EQ(two("m0 ", "m0 "), overlap);
  EXPECT_EQ(two("m0 ", ""), overlap);
  EXPECT_EQ(two("m0 ", "m1 "), "no error");
  EXPECT_EQ(two("m0 ", "m1M "), "no error");  // not decided here: refused where it is used
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
  } catch (const base::UsageError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Dbc, RequireRefusesWhatIsNotSupportedOnlyWhereItIsUsed) {
  const std::string tail = "|8@1+ (1,0) [0|0] \"\" A\n";
  const Database database = ParseDbc(
      kHeader + "BO_ 1 Nested: 8 A\n SG_ Which M : 0" + tail + " SG_ One m0M : 8" + tail +  //
          "BO_ 2 Half: 8 A\n SG_ F : 0|16@1- (1,0) [0|0] \"\" A\nBO_ 3 Long: 100 A\nBO_ 4 Plain: 8 A\n" +
          "BO_ 5 Several: 8 A\n SG_ Which M : 0" + tail + " SG_ One m1 : 8" + tail +  //
          "BO_ 6 Lost: 8 A\n SG_ One m1 : 8" + tail +                                 //
          "BO_ 7 Two: 8 A\n SG_ Which M : 0" + tail + " SG_ Other M : 8" + tail +     //
          "SIG_VALTYPE_ 2 F : 1;\nSG_MUL_VAL_ 5 One Which 1-1, 3-5;\n",
      "x.dbc");
  const std::string extended =
      "with extended multiplexing (m0M, or several values in SG_MUL_VAL_): only one multiplexer M and its "
      "m0, "
      "m1, ... are supported";
  EXPECT_EQ(RefusalOf(database, "Nested"), "x.dbc:9: message 'Nested' has the signal 'One' " + extended);
  EXPECT_EQ(RefusalOf(database, "Several"), "x.dbc:16: message 'Several' has the signal 'One' " + extended);
  EXPECT_EQ(
      RefusalOf(database, "Half"),
      "x.dbc:11: message 'Half' has the floating-point signal 'F' (SIG_VALTYPE_ 1) of 16 bits, expected "
      "32");
  EXPECT_EQ(RefusalOf(database, "Long"), "x.dbc:12: message 'Long' has 100 bytes; a CAN FD frame holds 64");
  EXPECT_EQ(RefusalOf(database, "Lost"),
            "x.dbc:18: message 'Lost' has the multiplexed signal 'One', but no multiplexer (M)");
  EXPECT_EQ(RefusalOf(database, "Two"),
            "x.dbc:21: message 'Two' has two multiplexers (M): 'Which' and 'Other'");
  EXPECT_EQ(RefusalOf(database, "Plain"), "no error");
}

TEST(Dbc, ReadsMultiplexingAsItIsWritten) {
  const Database database =
      ParseDbc(WithSignal("SG_ Which M : 0|8@1+ (1,0) [0|0] \"\" A\n SG_ S m12 : 8|8@1+ (1,0) [0|0] \"\" A") +
                   "SG_MUL_VAL_ 1 S Which 12-12;\n",
               "x.dbc");
  const Message& message = database.RequireMessage("M");
  ASSERT_NE(message.Selector(), nullptr);
  EXPECT_EQ(message.Selector()->name, "Which");
  EXPECT_EQ(message.signals[1].multiplexing, Multiplexing::kSelected);
  EXPECT_EQ(message.signals[1].selected_by, 12);
}

TEST(Dbc, AttributesTellFormatCycleAndStartValues) {
  // As CANdb++ writes them: the enumeration's index, and what is left out has the default.
  const std::string defines =
      "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"StandardCAN_FD\";\n"
      "BA_DEF_ BO_ \"CANFD_BRS\" ENUM \"0\",\"1\";\nBA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\n"
      "BA_DEF_ SG_ \"GenSigStartValue\" FLOAT 0 1E+10;\nBA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN\";\n"
      "BA_DEF_DEF_ \"CANFD_BRS\" \"1\";\nBA_DEF_DEF_ \"GenMsgCycleTime\" 100;\n";
  const Database database = ParseDbc(
      WithSignal("SG_ S : 0|8@1+ (1,0) [0|0] \"\" A") +
          "BO_ 2 Fd: 8 A\nBO_ 3 FdSlow: 8 A\nBO_ 4 Named: 8 A\nBO_ 5 Large: 12 A\n" + defines +
          "BA_ \"VFrameFormat\" BO_ 2 2;\nBA_ \"VFrameFormat\" BO_ 3 2;\nBA_ \"CANFD_BRS\" BO_ 3 0;\n"
          "BA_ \"VFrameFormat\" BO_ 4 \"StandardCAN_FD\";\nBA_ \"GenMsgCycleTime\" BO_ 1 20;\n"
          "BA_ \"GenSigStartValue\" SG_ 1 S 254;\nBA_ \"Unheard\" SG_ 1 S 1;\nBA_ \"Network\" 1;\n"
          "BA_ \"VFrameFormat\" BO_ 99 2;\n",
      "x.dbc");
  EXPECT_FALSE(database.FindMessage("M")->fd);
  EXPECT_FALSE(database.FindMessage("M")->bit_rate_switch);
  EXPECT_EQ(database.FindMessage("M")->cycle_ms, 20);
  EXPECT_EQ(database.FindMessage("M")->signals[0].start_raw, 254.0);
  EXPECT_TRUE(database.FindMessage("Fd")->fd);
  EXPECT_TRUE(database.FindMessage("Fd")->bit_rate_switch);
  EXPECT_EQ(database.FindMessage("Fd")->cycle_ms, 100);
  EXPECT_TRUE(database.FindMessage("FdSlow")->fd);
  EXPECT_FALSE(database.FindMessage("FdSlow")->bit_rate_switch);
  EXPECT_TRUE(database.FindMessage("Named")->fd);
  EXPECT_TRUE(database.FindMessage("Large")->fd);  // no other frame holds it
}

TEST(Dbc, OddAttributesArePassedOver) {
  EXPECT_EQ(ErrorOf(WithSignal("SG_ S : 0|8@1+ (1,0) [0|0] \"\" A") +
                    "BA_DEF_ ;\nBA_DEF_ BO_ ;\nBA_DEF_ BO_ \"E\" ENUM ;\nBA_DEF_DEF_ \"E\" ;\nBA_ ;\n"
                    "BA_ \"E\" BO_ x 1;\nBA_ \"E\" BO_ -1 1;\nBA_ \"E\" BO_ 1 1;\nBA_ \"E\" BO_ 1 1E9;\n"
                    "BA_ \"GenMsgCycleTime\" BO_ 1 1E300;\nBA_ \"GenSigStartValue\" SG_ 1 S \"no\";\n"),
            "no error");
}

TEST(Dbc, SuggestsTheNearestName) {
  const Database database = ParseDbc(WithSignal("SG_ Pressure : 0|8@1+ (1,0) [0|0] \"\" A"), "x.dbc");
  EXPECT_EQ(RefusalOf(database, "Nothing"), "x.dbc: no message 'Nothing'; there are 1: M");
  try {
    database.RequireSignal(database.messages[0], "Presure");
    FAIL();
  } catch (const base::UsageError& error) {
    EXPECT_STREQ(error.what(), "x.dbc:7: message 'M' has no signal 'Presure'; the nearest is 'Pressure'");
  }
}

TEST(Dbc, SeveralFilesAreOneAsLongAsNothingIsInDoubt) {
  Databases both;
  both.files = {ParseDbc("BO_ 1 A: 8 X\nBO_ 2 B: 8 X\nBO_ 3 C: 8 X\n", "one.dbc"),
                ParseDbc("BO_ 4 D: 8 X\nBO_ 2 E: 8 X\nBO_ 5 C: 8 X\nBO_ 2147483649 F: 8 X\n", "two.dbc")};
  const auto refusal = [&](const std::string& name) -> std::string {
    try {
      both.RequireMessage(name);
    } catch (const base::UsageError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(both.RequireMessage("D").database->file, "two.dbc");
  EXPECT_EQ(both.RequireMessage("D").message->line, 1);
  EXPECT_EQ(refusal("A"), "no error");
  EXPECT_EQ(refusal("F"), "no error");  // id 1 of 29 bits
  EXPECT_EQ(refusal("B"),
            "two.dbc:2: message 'E' has the id of 'B' in one.dbc:2: leave one of the two files out");
  EXPECT_EQ(refusal("C"),
            "two.dbc:3: message 'C' has the name of 'C' in one.dbc:3: leave one of the two files out");
  EXPECT_EQ(refusal("Gov"), "one.dbc, two.dbc: no message 'Gov'; there are 7: A B C D E C ...");
}

TEST(Dbc, AFileThatIsNotThereIsAUsageError) {
  EXPECT_THROW(ReadDbc("/nowhere/x.dbc"), base::UsageError);
  EXPECT_THROW(ReadDbc("/tmp"), base::UsageError);
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

// VFrameFormat is an enumeration or a number, set or by default, by name or by index.
TEST(Dbc, TheFrameFormatIsReadInEachForm) {
  const std::string message = "BO_ 1 GOV: 8 X\n SG_ P1 : 0|16@1+ (1,0) [0|0] \"\" X\n";
  const std::string names =
      "\"StandardCAN\",\"ExtendedCAN\",\"r\",\"J1939PG\",\"r\",\"r\",\"r\",\"r\",\"r\",\"r\",\"r\",\"r\","
      "\"r\",\"r\","
      "\"StandardCAN_FD\",\"ExtendedCAN_FD\"";
  const std::string of_names = "BA_DEF_ BO_ \"VFrameFormat\" ENUM " + names + ";\n";
  const std::string of_numbers = "BA_DEF_ BO_ \"VFrameFormat\" INT 0 15;\n";
  const auto read = [&](const std::string& attributes) {
    return ParseDbc(message + attributes, "x.dbc").messages.front();
  };
  EXPECT_TRUE(read(of_names + "BA_DEF_DEF_ \"VFrameFormat\" 14;\n").fd);
  EXPECT_TRUE(read(of_names + "BA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN_FD\";\n").fd);
  EXPECT_TRUE(read(of_names + "BA_ \"VFrameFormat\" BO_ 1 14;\n").fd);
  EXPECT_TRUE(read(of_names + "BA_ \"VFrameFormat\" BO_ 1 \"StandardCAN_FD\";\n").fd);
  EXPECT_TRUE(read(of_numbers + "BA_DEF_DEF_ \"VFrameFormat\" 0;\nBA_ \"VFrameFormat\" BO_ 1 14;\n").fd);
  EXPECT_TRUE(read(of_numbers + "BA_DEF_DEF_ \"VFrameFormat\" 15;\n").fd);
  EXPECT_TRUE(read(of_numbers + "BA_ \"VFrameFormat\" BO_ 1 3;\n").j1939);
  EXPECT_FALSE(read(of_names + "BA_DEF_DEF_ \"VFrameFormat\" 0;\n").fd);
  EXPECT_FALSE(read(of_names + "BA_DEF_DEF_ \"VFrameFormat\" 14;\nBA_ \"VFrameFormat\" BO_ 1 0;\n").fd);
}

TEST(Dbc, LinesMayEndInAnyWay) {
  const std::string text =
      "VERSION \"\"\n\nBU_: A B\n\nBO_ 1 GOV: 8 A\n SG_ P1 : 0|16@1+ (1,0) [0|0] \"psi\" B\n\nCM_ BO_ 1 \"two\nlines\";\n";
  const auto with = [&](const std::string& end) {
    std::string other;
    for (const char c : text) other += c == '\n' ? end : std::string(1, c);
    return other;
  };
  for (const char* end : {"\n", "\r\n", "\r"}) {
    const Database dbc = ParseDbc(with(end), "x.dbc");
    ASSERT_EQ(dbc.messages.size(), 1U);
    EXPECT_EQ(dbc.messages[0].line, 5);
    EXPECT_EQ(dbc.messages[0].signals.at(0).line, 6);
    EXPECT_EQ(dbc.messages[0].comment, "two\nlines");
  }
}

}  // namespace
}  // namespace servohil::can
