#include "fault/effects.hpp"

#include <algorithm>

namespace servohil::fault {
namespace {

/// Calls `apply(act, injection, share)` for each fault of this kind that acts during `tick`.
template <typename Kind, typename Apply>
void ForEachActing(const Schedule& schedule, std::uint64_t tick, Apply&& apply) noexcept {
  for (const Injection& injection : schedule) {
    const Kind* act = std::get_if<Kind>(&Find(injection.id)->act);
    const double share = act == nullptr ? 0.0 : injection.ShareAt(tick);
    if (share > 0.0) apply(*act, injection, share);
  }
}

}  // namespace

bool ActsOnPublished(const Schedule& schedule, std::uint64_t tick) noexcept {
  bool acts = false;
  ForEachActing<TransmitAct>(schedule, tick, [&](TransmitAct, const Injection&, double) { acts = true; });
  return acts;
}

Transmission FateOfPublished(const Schedule& schedule, std::uint8_t message, std::uint64_t tick) noexcept {
  Transmission fate;
  ForEachActing<TransmitAct>(schedule, tick, [&](TransmitAct act, const Injection& injection, double share) {
    if (injection.target != Injection::kEverything && injection.target != message) return;
    Random random(injection.seed, injection.id, message, tick);
    act(fate, injection.values, share, random);
  });
  return fate;
}

Reception FateOfArrived(const Schedule& schedule, std::uint64_t number, std::uint64_t tick) noexcept {
  Reception fate;
  ForEachActing<ReceiveAct>(schedule, tick, [&](ReceiveAct act, const Injection& injection, double share) {
    Random random(injection.seed, injection.id, injection.target, number);
    act(fate, injection.values, share, random);
  });
  return fate;
}

Line LineAt(const Schedule& schedule, std::uint64_t tick) noexcept {
  Line line;
  ForEachActing<LineAct>(schedule, tick, [&](LineAct act, const Injection& injection, double share) {
    act(line, injection.values, share);
  });
  return line;
}

Stall StallAt(const Schedule& schedule, std::uint64_t tick) noexcept {
  Stall stall;
  ForEachActing<StallAct>(schedule, tick, [&](StallAct act, const Injection& injection, double) {
    if (injection.StartsAt(tick)) act(stall, injection.values);
  });
  return stall;
}

void FlipBits(std::span<std::uint8_t> data, int count, std::uint64_t key) noexcept {
  // Knuth's selection sampling (The Art of Computer Programming 2, 3.4.2, algorithm S): each bit with the
  // chance of those still wanted to those still left.
  constexpr int kBitsPerByte = 8;
  const int bits = static_cast<int>(data.size()) * kBitsPerByte;
  Random random(key, 0, 0, 0);
  int wanted = std::min(count, bits);
  for (int i = 0; i < bits && wanted > 0; ++i) {
    if (!random.Chance(static_cast<double>(wanted) / (bits - i))) continue;
    data[static_cast<std::size_t>(i / kBitsPerByte)] ^= static_cast<std::uint8_t>(1U << (i % kBitsPerByte));
    --wanted;
  }
}

}  // namespace servohil::fault
