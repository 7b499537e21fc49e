#pragma once
/// What a scenario file says, understood: a run of so long, what happens in it, what is expected of it.
///
/// Scenario time counts in ticks of 0.1 ms from the governor's first command on: it is 0 when the first tick
/// begins that has a command. `servohil simulate` commands the pressure of rest from the beginning.

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "configuration/configuration.hpp"
#include "recording/recording.hpp"
#include "recording/sample_columns.hpp"

namespace servohil::scenario {

/// P1 from its time on: a step, a ramp to a new value, or a sine around it.
struct CommandStep {
  std::uint64_t at_tick = 0;
  double p1_psi = 0.0;     ///< absolute, or more than before
  bool is_change = false;  ///< p1_psi is more than before
  std::uint64_t ramp_ticks = 0;
  double amplitude_psi = 0.0;
  double frequency_hz = 0.0;
};

/// What is expected of a run; PASS or FAIL.
struct Expectation {
  enum class Kind : std::uint8_t {
    kWithin,       ///< |quantity - of| <= within
    kBetween,      ///< above <= quantity <= below, either may be infinite
    kSettles,      ///< as kWithin, from by_s on
    kCalm,         ///< largest less smallest at most peak_to_peak
    kOscillates,   ///< swings by at least peak_to_peak all the time, at a frequency between the two
    kModeBecomes,  ///< the mode becomes `mode` between the two ticks
    kModeNever,    ///< the mode is never `mode`
  };
  static constexpr double kAny = std::numeric_limits<double>::infinity();

  Kind kind = Kind::kWithin;
  const recording::SampleColumn* quantity = nullptr;  ///< none of the mode's
  double of = 0.0;
  double within = 0.0;
  double above = -kAny;
  double below = kAny;
  double peak_to_peak = 0.0;
  double lowest_hz = 0.0;
  double highest_hz = kAny;
  simulation::Mode mode = simulation::Mode::kWaiting;
  std::string after;            ///< "load_step", for a mode that is to follow a fault; empty: a time
  std::uint64_t from_tick = 0;  ///< state after so many ticks: the first that is looked at; kSettles: by_s
  std::uint64_t to_tick = 0;    ///< the last
  int line = 0;                 ///< in the file
};

struct Scenario {
  std::filesystem::path file;
  std::string about;  ///< one line; may be empty
  std::uint64_t duration_ticks = 0;
  std::uint64_t wait_ticks = 0;  ///< for the first command, on a bus
  std::vector<CommandStep> commands;
  std::vector<recording::Stimulus> faults;  ///< their ticks count from the start of scenario time
  std::vector<Expectation> expectations;
};

/// "x3 within 0.01 in of 4 in from 0.5 s to 1 s": an expectation as a person says it.
std::string TextOf(const Expectation& expectation);

/// "x3" of "x3_in"; its unit: "in".
std::string NameOf(const recording::SampleColumn& quantity);
std::string WithUnit(double value, const recording::SampleColumn& quantity);

}  // namespace servohil::scenario
