// Any bytes from a serial line: no piece of it confuses the next, and what is a frame comes back as it went.

#include "can/slcan/slcan_codec.hpp"
#include "can/slcan/slcan_session.hpp"
#include "fuzz.hpp"

namespace {

namespace slcan = servohil::can::slcan;

void RequireSameFrame(std::string_view line) {
  const auto frame = slcan::ParseFrame(line, slcan::Timestamp::kAllowed);
  if (!frame) return;
  const slcan::LineText text = slcan::FormatFrame(*frame, std::nullopt);
  Require(text.View().size() >= 2 && text.View().back() == '\r', "a line ends in CR");
  const auto again = slcan::ParseFrame(text.View().substr(0, text.size - 1), slcan::Timestamp::kRefused);
  Require(again && again->id == frame->id && again->extended == frame->extended &&
              again->remote == frame->remote && again->fd == frame->fd && again->size == frame->size &&
              again->data == frame->data,
          "a frame comes back as it went");
}

}  // namespace

int FuzzOne(std::string_view bytes) {
  slcan::LineAssembler assembler;
  slcan::Session session;
  for (const char byte : bytes) {
    const auto line = assembler.Push(byte);
    if (!line || line->kind != slcan::LineKind::kText) continue;
    Require(line->text.size() <= slcan::kLongestLine, "a line is bounded");
    RequireSameFrame(line->text);
    const slcan::Answer answer = session.Handle(line->text);
    Require(!answer.frame || session.IsOpen(), "no frame while the channel is closed");
    Require(!answer.malformed || answer.text == "\a", "what is malformed is answered with BEL");
  }
  return 0;
}
