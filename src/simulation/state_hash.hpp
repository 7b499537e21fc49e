#pragma once
/// The state hash: 64 bits that stand for a whole trajectory, so that two runs are compared by one number.

#include <array>
#include <bit>
#include <cstdint>

#include "simulation/sample.hpp"

namespace servohil::simulation {

/// Both halves of the 128-bit product, folded: every bit of the result depends on all of both factors (the
/// principle of wyhash, Wang Yi, https://github.com/wangyi-fudan/wyhash).
inline std::uint64_t Fold(std::uint64_t a, std::uint64_t b) noexcept {
  __extension__ using Wide = unsigned __int128;
  const Wide product = static_cast<Wide>(a) * b;
  return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64);
}

/// Replaces `sample.state_hash`, the one of the tick before, by that of this tick: a hash of the sample's
/// bits, chained with the one before. Doubles count by their bits: 0.0 and -0.0 differ. Real-time safe.
inline void ExtendStateHash(Sample& sample) noexcept {
  const model::State& s = sample.state;
  const auto flag = [](bool value) noexcept { return static_cast<std::uint64_t>(value); };
  const std::uint64_t discrete = static_cast<std::uint64_t>(s.mode.motion) |
                                 static_cast<std::uint64_t>(s.mode.plunger) << 8 |
                                 flag(s.mode.diaphragm_seated) << 16 | flag(s.mode.relay_port_full) << 17 |
                                 flag(sample.model_fault) << 18;
  const std::array<std::uint64_t, 10> words = {
      sample.tick,
      std::bit_cast<std::uint64_t>(sample.p1_psi),
      std::bit_cast<std::uint64_t>(s.x3_in),
      std::bit_cast<std::uint64_t>(s.v3_in_s),
      std::bit_cast<std::uint64_t>(s.p3_psi),
      std::bit_cast<std::uint64_t>(s.p4_psi),
      std::bit_cast<std::uint64_t>(s.p8_psi),
      std::bit_cast<std::uint64_t>(s.p2_psi),
      sample.unresolved_ticks,
      discrete,
  };
  std::uint64_t hash = sample.state_hash;
  std::uint64_t key = 0x9E3779B97F4A7C15U;  // another one for each word
  for (std::size_t i = 0; i < words.size(); i += 2) {
    hash += Fold(words[i] ^ key, words[i + 1] ^ (key + 0xD1342543DE82EF95U));
    key *= 0xD1342543DE82EF95U;
  }
  sample.state_hash = Fold(hash ^ 0xE7037ED1A0B428DBU, 0xA0761D6478BD642FU);
}

}  // namespace servohil::simulation
