#pragma once
/// Faults of the bus and of the emulator itself.
/// A part of the catalogue's table: read by catalogue.cpp alone.

#include "fault/parameter_acts.hpp"
#include "model/step.hpp"

namespace servohil::fault {

inline constexpr double kTicksPerMs = 1e-3 / model::kTickS;
inline constexpr double kMaxMs = 10'000.0;

inline std::uint32_t TicksOfMs(double ms) noexcept {
  return static_cast<std::uint32_t>(std::lround(ms * kTicksPerMs));
}

inline constexpr ParameterSpec kProbability = {"probability", "", 0.0, 1.0, 0.5, "of each frame to be hit"};
inline constexpr ParameterSpec kAlways = {"probability", "", 0.0, 1.0, 1.0, "of each frame to be hit"};

inline constexpr std::array kBusFaults = std::to_array<Spec>({
    {80,
     "tx_silent",
     Part::kBus,
     {},
     "Nothing is published any more, at once.",
     [](Transmission& t, const V&, double, Random&) noexcept { t.lost = true; },
     Needs::kBus},
    {81,
     "tx_lost",
     Part::kBus,
     {{kProbability}},
     "Published frames are lost at random.",
     [](Transmission& t, const V& v, double share, Random& random) noexcept {
       t.lost = random.Chance(share * v[0]) || t.lost;
     },
     Needs::kBus,
     false,
     true},
    {82,
     "tx_delayed",
     Part::kBus,
     {{{"delay_ms", "ms", 0.0, kMaxMs, 50.0, "from publication to the bus"}}},
     "Published frames are late, all by the same time.",
     [](Transmission& t, const V& v, double share, Random&) noexcept {
       t.delay_ticks += TicksOfMs(share * v[0]);
     },
     Needs::kBus},
    {83,
     "tx_jittered",
     Part::kBus,
     {{{"most_ms", "ms", 0.0, kMaxMs, 5.0, "longest delay; all from 0 to it are equally likely"}}},
     "Published frames are late, each by another time; one may overtake another.",
     [](Transmission& t, const V& v, double share, Random& random) noexcept {
       t.delay_ticks += TicksOfMs(share * v[0] * random.Uniform());
     },
     Needs::kBus,
     false,
     true},
    {84,
     "tx_duplicated",
     Part::kBus,
     {{kAlways}},
     "Published frames come twice.",
     [](Transmission& t, const V& v, double share, Random& random) noexcept {
       if (random.Chance(share * v[0])) t.copies = 2;
     },
     Needs::kBus,
     false,
     true},
    {85,
     "tx_reordered",
     Part::kBus,
     {{kProbability}},
     "Published frames are overtaken by the next one of their message.",
     [](Transmission& t, const V& v, double share, Random& random) noexcept {
       t.after_next = random.Chance(share * v[0]) || t.after_next;
     },
     Needs::kBus,
     false,
     true},
    {86,
     "counter_stuck",
     Part::kBus,
     {},
     "The counter in published frames stands still, with a checksum that is right.",
     [](Transmission& t, const V&, double, Random&) noexcept { t.counter_stuck = true; },
     Needs::kCounter},
    {87,
     "checksum_wrong",
     Part::kBus,
     {{kAlways}},
     "The checksum of published frames is wrong.",
     [](Transmission& t, const V& v, double share, Random& random) noexcept {
       t.checksum_wrong = random.Chance(share * v[0]) || t.checksum_wrong;
     },
     Needs::kChecksum,
     false,
     true},
    {88,
     "bits_flipped",
     Part::kBus,
     {{{"bits", "", 1.0, 64.0, 1.0, "how many of a frame's data bits are inverted"}, kAlways}},
     "Data bits of published frames are inverted at random, after protection: a fault that no CAN checksum "
     "has seen.",
     [](Transmission& t, const V& v, double share, Random& random) noexcept {
       if (!random.Chance(share * v[1])) return;
       t.flipped_bits = static_cast<std::uint8_t>(std::lround(v[0]));
       t.flip_key = random.Next();
     },
     Needs::kBus,
     false,
     true},
    {89,
     "babbling",
     Part::kBus,
     {{{"id", "", 0.0, 2047.0, 0.0, "standard identifier of the frames; 0 wins every arbitration"},
       {"rate_hz", "Hz", 0.0, 20'000.0, 1'000.0, "frames a second"}}},
     "The node talks without end: frames of 8 zero bytes that nobody asked for.",
     [](Line& line, const V& v, double share) noexcept {
       line.babble_id = static_cast<std::uint32_t>(std::lround(v[0]));
       line.babble_hz = share * v[1];
     },
     Needs::kBus},
    {90,
     "rx_lost",
     Part::kBus,
     {{kProbability}},
     "Frames that arrive are lost at random.",
     [](Reception& r, const V& v, double share, Random& random) noexcept {
       r.lost = random.Chance(share * v[0]) || r.lost;
     },
     Needs::kBus,
     false,
     true},
    {91,
     "rx_delayed",
     Part::kBus,
     {{{"delay_ms", "ms", 0.0, kMaxMs, 50.0, "from the bus to their evaluation"}}},
     "Frames that arrive are late: what they command acts later.",
     [](Reception& r, const V& v, double share, Random&) noexcept {
       r.delay_ticks += TicksOfMs(share * v[0]);
     },
     Needs::kBus},
    {92,
     "interface_down",
     Part::kBus,
     {},
     "The interface is as if unplugged, at once: nothing is sent, nothing received.",
     [](Line& line, const V&, double) noexcept { line.down = true; },
     Needs::kBus},
    {93,
     "error_frames",
     Part::kBus,
     {{{"rate_hz", "Hz", 0.0, 1'000.0, 10.0, "error frames a second"}}},
     "Error frames are on the bus: a bit error in the data field each.",
     [](Line& line, const V& v, double share) noexcept { line.errors_hz = share * v[0]; },
     Needs::kErrorFrames},
    {94,
     "missed_ticks",
     Part::kEmulator,
     {{{"ms", "ms", 1.0, 5'000.0, 20.0, "for which no tick is run; then they are caught up"}}},
     "The emulator misses its deadlines, once at the start of each pulse: late ticks, an overrun if there "
     "are "
     "many.",
     [](Stall& stall, const V& v) noexcept { stall.ms += v[0]; },
     Needs::kRealTime},
});

}  // namespace servohil::fault
