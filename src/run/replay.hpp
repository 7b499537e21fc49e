#pragma once
/// Compares a run that is repeated with its recording.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "emulator/simulation_task.hpp"
#include "recording/reader.hpp"

namespace servohil::run {

/// Where a replay first differs from its recording, and in what.
struct Difference {
  std::uint64_t tick = 0;
  std::string variable;
  std::string recorded;
  std::string replayed;
};

/// How far a column of the replay gets from the recording.
struct Deviation {
  std::string variable;
  std::string unit;
  double largest = 0.0;
  std::uint64_t tick = 0;  ///< where
};

/// Compares a replay with the recording, tick by tick, while it runs.
class Comparison {
 public:
  /// @param recording  must outlive it
  explicit Comparison(const recording::RecordingReader& recording);

  /// After each tick, in order. @return false once the recording has no more samples
  bool Take(const simulation::RunState& replayed);

  const std::optional<Difference>& FirstDifference() const noexcept { return difference_; }
  /// Of the quantities that are real numbers; none where it is 0.
  std::vector<Deviation> LargestDeviations() const;
  std::uint64_t ComparedSamples() const noexcept { return compared_; }

 private:
  const simulation::RunState* Recorded(std::uint64_t tick);
  void Compare(simulation::RunState recorded, simulation::RunState replayed);

  const recording::RecordingReader& recording_;
  std::vector<simulation::RunState> block_;
  std::uint64_t next_row_ = 0;
  std::size_t at_ = 0;
  bool exhausted_ = false;
  std::uint64_t compared_ = 0;
  std::optional<Difference> difference_;
  std::vector<Deviation> deviations_;
};

}  // namespace servohil::run
