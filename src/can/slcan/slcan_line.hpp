#pragma once
/// A serial byte stream as lines, whatever the pieces in which it arrives.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace servohil::can::slcan {

/// The longest line there is: B, 8 digits of id, length code, 64 data bytes, time stamp.
inline constexpr std::size_t kLongestLine = 1 + 8 + 1 + 2 * 64 + 4;

enum class LineKind : std::uint8_t {
  kText,     ///< printable ASCII; empty for a lone CR
  kBell,     ///< BEL on its own: "command refused"
  kGarbage,  ///< over-long, bytes that no line has, or cut off by a BEL
};

struct Line {
  LineKind kind;
  std::string_view text;  ///< of kText, without its CR; valid until the next Push()
};

/// Lines end at CR; a line feed before one is ignored. After garbage it resynchronises at the next CR.
/// Allocates nothing.
class LineAssembler {
 public:
  /// @return the line that `byte` completes
  std::optional<Line> Push(char byte) noexcept;
  /// Forgets an incomplete line.
  void Clear() noexcept;

 private:
  Line Finish() noexcept;

  std::array<char, kLongestLine> buffer_{};
  std::size_t size_ = 0;
  bool garbage_ = false;
};

}  // namespace servohil::can::slcan
