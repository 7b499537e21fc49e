#include "can/slcan/slcan_session.hpp"

#include <gtest/gtest.h>

namespace servohil::can::slcan {
namespace {

constexpr std::string_view kOk = "\r";
constexpr std::string_view kRefused = "\a";

TEST(SlcanSession, TheUsualStart) {
  Session session;
  EXPECT_EQ(session.Handle("C").text, kRefused);  // nothing to close
  EXPECT_EQ(session.Handle("S6").text, kOk);
  EXPECT_EQ(session.Handle("O").text, kOk);
  EXPECT_TRUE(session.IsOpen());
  EXPECT_EQ(session.Handle("O").text, kRefused);
  EXPECT_EQ(session.Handle("S6").text, kRefused);
  EXPECT_EQ(session.Handle("C").text, kOk);
  EXPECT_FALSE(session.IsOpen());
}

TEST(SlcanSession, AcknowledgesFramesByTheirFormat) {
  Session session;
  session.Handle("O");
  for (const char* line : {"t1230", "r1230", "d1230", "b1230"})
    EXPECT_EQ(session.Handle(line).text, "z\r") << line;
  for (const char* line : {"T000001230", "R000001230", "D000001230", "B000001230"}) {
    EXPECT_EQ(session.Handle(line).text, "Z\r") << line;
  }
}

TEST(SlcanSession, RefusesFramesWhileClosedOrListening) {
  Session session;
  EXPECT_EQ(session.Handle("t1230").text, kRefused);
  session.Handle("L");
  EXPECT_TRUE(session.IsOpen());
  const Answer answer = session.Handle("t1230");
  EXPECT_EQ(answer.text, kRefused);
  EXPECT_FALSE(answer.frame);
  EXPECT_FALSE(answer.malformed);
  session.Handle("C");
  session.Handle("O");
  EXPECT_TRUE(session.Handle("t1230").frame);
}

TEST(SlcanSession, KnowsEveryCommand) {
  Session session;
  for (const char* line : {"S0", "S8", "s031C", "Y2", "Z1", "Z0", "M00000000", "mFFFFFFFF", "M0", ""}) {
    EXPECT_EQ(session.Handle(line).text, kOk) << line;
  }
  EXPECT_EQ(session.Handle("V").text, "V0101\r");
  EXPECT_EQ(session.Handle("N").text, "NHIL1\r");
  for (const char* line : {"S9", "S", "S66", "s03", "s031G", "Z2", "M", "Mx", "OO", "V1", "X1", "?"}) {
    const Answer answer = session.Handle(line);
    EXPECT_EQ(answer.text, kRefused) << line;
    EXPECT_TRUE(answer.malformed) << line;
  }
}

TEST(SlcanSession, FlagsSayOnceThatFramesWereLost) {
  Session session;
  EXPECT_EQ(session.Handle("F").text, kRefused);
  session.Handle("O");
  EXPECT_EQ(session.Handle("F").text, "F00\r");
  session.SetOverrun();
  EXPECT_EQ(session.Handle("F").text, "F08\r");
  EXPECT_EQ(session.Handle("F").text, "F00\r");
}

TEST(SlcanSession, TimestampsOnlyChangeWhileClosed) {
  Session session;
  session.Handle("Z1");
  EXPECT_TRUE(session.HasTimestamps());
  session.Handle("O");
  EXPECT_EQ(session.Handle("Z0").text, kRefused);
  EXPECT_TRUE(session.HasTimestamps());
  session.Reset();
  EXPECT_FALSE(session.HasTimestamps());
  EXPECT_FALSE(session.IsOpen());
}

}  // namespace
}  // namespace servohil::can::slcan
