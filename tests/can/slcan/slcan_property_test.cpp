#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>
#include <vector>

#include "can/data_length.hpp"
#include "can/slcan/slcan_codec.hpp"
#include "can/slcan/slcan_line.hpp"
#include "can/slcan/slcan_session.hpp"

namespace servohil::can::slcan {
namespace {

rc::Gen<Frame> AnyFrame() {
  return rc::gen::exec([] {
    Frame frame;
    frame.extended = *rc::gen::arbitrary<bool>();
    frame.id = *rc::gen::inRange(0U, frame.extended ? 0x2000'0000U : 0x800U);
    frame.fd = *rc::gen::arbitrary<bool>();
    frame.bit_rate_switch = frame.fd && *rc::gen::arbitrary<bool>();
    frame.remote = !frame.fd && *rc::gen::arbitrary<bool>();
    frame.size = kSizeOfCode[static_cast<std::size_t>(*rc::gen::inRange(0, frame.fd ? 16 : 9))];
    for (std::size_t i = 0; !frame.remote && i < frame.size; ++i)
      frame.data[i] = *rc::gen::arbitrary<std::uint8_t>();
    return frame;
  });
}

bool Same(const Frame& a, const Frame& b) {
  return a.id == b.id && a.extended == b.extended && a.remote == b.remote && a.fd == b.fd &&
         a.bit_rate_switch == b.bit_rate_switch && a.size == b.size && a.data == b.data;
}

/// What comes of a stream: its frames as lines, and how many lines were none.
struct Outcome {
  std::vector<std::string> frames;
  std::size_t malformed = 0;
  bool operator==(const Outcome&) const = default;
};

void Push(LineAssembler& assembler, std::string_view bytes, Outcome& outcome) {
  for (const char byte : bytes) {
    const auto line = assembler.Push(byte);
    if (!line) continue;
    const auto frame =
        line->kind == LineKind::kText ? ParseFrame(line->text, Timestamp::kAllowed) : std::nullopt;
    if (frame) {
      outcome.frames.emplace_back(FormatFrame(*frame, std::nullopt).View());
    } else {
      ++outcome.malformed;
    }
  }
}

/// Bytes that often are almost frames: pieces of real lines, digits, line ends, noise.
rc::Gen<std::string> AnyStream() {
  const auto line = rc::gen::map(
      AnyFrame(), [](const Frame& frame) { return std::string(FormatFrame(frame, std::nullopt).View()); });
  const auto cut = rc::gen::map(rc::gen::pair(line, rc::gen::inRange<std::size_t>(0, 20)),
                                [](const auto& pair) { return pair.first.substr(0, pair.second); });
  const auto noise = rc::gen::container<std::string>(rc::gen::arbitrary<char>());
  const auto digits =
      rc::gen::container<std::string>(rc::gen::element('0', 'F', 't', 'T', 'b', '\r', '\n', '\a', 'z'));
  const auto piece = rc::gen::oneOf(line, line, cut, noise, digits);
  return rc::gen::map(rc::gen::container<std::vector<std::string>>(piece),
                      [](const std::vector<std::string>& all) {
                        std::string stream;
                        for (const std::string& one : all) stream += one;
                        return stream;
                      });
}

RC_GTEST_PROP(SlcanProperty, WhatIsFormattedParses, ()) {
  const Frame frame = *AnyFrame();
  const auto stamp = *rc::gen::maybe(rc::gen::inRange<std::uint16_t>(0, 60'000));
  std::optional<std::uint16_t> timestamp;
  if (stamp) timestamp = *stamp;
  const LineText line = FormatFrame(frame, timestamp);
  const auto parsed = ParseFrame(line.View().substr(0, line.size - 1), Timestamp::kAllowed);
  RC_ASSERT(parsed.has_value());
  RC_ASSERT(Same(*parsed, frame));
}

RC_GTEST_PROP(SlcanProperty, AStreamIsTheSameHoweverItIsCut, ()) {
  const std::string stream = *AnyStream();
  Outcome whole;
  LineAssembler one;
  Push(one, stream, whole);
  Outcome pieces;
  LineAssembler other;
  for (std::size_t at = 0; at < stream.size();) {
    const std::size_t size = *rc::gen::inRange<std::size_t>(1, 10);
    Push(other, std::string_view(stream).substr(at, size), pieces);
    at += size;
  }
  RC_ASSERT(whole == pieces);
}

RC_GTEST_PROP(SlcanProperty, AfterNoiseTheNextLineButOneIsRead, ()) {
  const auto noise = *rc::gen::container<std::string>(rc::gen::arbitrary<char>());
  const std::string line(FormatFrame(*AnyFrame(), std::nullopt).View());
  Outcome outcome;
  LineAssembler assembler;
  Push(assembler, noise + "\r" + line, outcome);
  RC_ASSERT(!outcome.frames.empty());
  RC_ASSERT(outcome.frames.back() == line);
}

RC_GTEST_PROP(SlcanProperty, ASessionAnswersAnyLineAndGivesFramesOnlyWhileOpen, ()) {
  Session session;
  const auto lines = *rc::gen::container<std::vector<std::string>>(
      rc::gen::oneOf(rc::gen::element<std::string>("O", "L", "C", "S6", "F", "Z1", "V"),
                     rc::gen::container<std::string>(rc::gen::inRange(' ', '~')),
                     rc::gen::map(AnyFrame(), [](const Frame& frame) {
                       const LineText line = FormatFrame(frame, std::nullopt);
                       return std::string(line.View().substr(0, line.size - 1));
                     })));
  for (const std::string& line : lines) {
    const bool may_send = session.IsOpen() && !session.IsListenOnly();
    const Answer answer = session.Handle(line);
    RC_ASSERT(!answer.text.empty());
    RC_ASSERT(answer.text.back() == '\r' || answer.text == "\a");
    RC_ASSERT(!answer.frame || may_send);
  }
}

TEST(SlcanLine, AnOverlongLineIsGarbageAndTheNextOneIsNot) {
  Outcome outcome;
  LineAssembler assembler;
  Push(assembler, "t1230" + std::string(kLongestLine, '0') + "\rt1230\r", outcome);
  EXPECT_EQ(outcome.malformed, 1U);
  EXPECT_EQ(outcome.frames, std::vector<std::string>{"t1230\r"});
}

TEST(SlcanLine, ABellCutsALineOff) {
  Outcome outcome;
  LineAssembler assembler;
  Push(assembler, "t123\at1230\r\a", outcome);
  EXPECT_EQ(outcome.malformed, 2U);  // the cut line, the bell on its own
  EXPECT_EQ(outcome.frames, std::vector<std::string>{"t1230\r"});
}

}  // namespace
}  // namespace servohil::can::slcan
