#include "can/slcan/slcan_line.hpp"

namespace servohil::can::slcan {

Line LineAssembler::Finish() noexcept {
  const Line line{garbage_ ? LineKind::kGarbage : LineKind::kText, {buffer_.data(), garbage_ ? 0 : size_}};
  Clear();
  return line;
}

void LineAssembler::Clear() noexcept {
  size_ = 0;
  garbage_ = false;
}

std::optional<Line> LineAssembler::Push(char byte) noexcept {
  const bool empty = size_ == 0 && !garbage_;
  if (byte == '\r') return Finish();
  if (byte == '\n' && empty) return std::nullopt;
  if (byte == '\a') {
    if (empty) return Line{LineKind::kBell, {}};
    garbage_ = true;
    return Finish();
  }
  if (byte < ' ' || byte > '~' || size_ == buffer_.size()) {
    garbage_ = true;
  } else {
    buffer_[size_++] = byte;
  }
  return std::nullopt;
}

}  // namespace servohil::can::slcan
