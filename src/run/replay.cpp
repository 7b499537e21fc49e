#include "run/replay.hpp"

#include <cmath>
#include <cstring>
#include <type_traits>

#include "base/formatted.hpp"
#include "recording/sample_columns.hpp"

namespace servohil::run {
namespace {

constexpr std::size_t kBlockRows = 16'384;

std::string Shown(double value) {
  return base::Formatted("%.17g", value);
}
template <typename T>
std::string Shown(T value) {
  if constexpr (std::is_enum_v<T>) {
    return std::to_string(static_cast<int>(value));
  } else {
    return std::to_string(value);
  }
}

template <typename T>
bool SameBits(const T& a, const T& b) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): bits are meant; NaN equals itself, -0 is not 0
  return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

Comparison::Comparison(const recording::RecordingReader& recording) : recording_(recording) {
  for (const recording::SampleColumn& column : recording::SampleColumns())
    deviations_.push_back({column.name, column.unit});
}

/// The recorded sample of a tick; null where none was recorded.
const simulation::RunState* Comparison::Recorded(std::uint64_t tick) {
  while (!exhausted_) {
    if (at_ == block_.size()) {
      block_.resize(kBlockRows);
      block_.resize(recording_.ReadSamples(next_row_, block_));
      next_row_ += block_.size();
      at_ = 0;
      exhausted_ = block_.empty();
      continue;
    }
    if (block_[at_].sample.tick > tick) return nullptr;
    if (block_[at_].sample.tick == tick) return &block_[at_++];
    ++at_;
  }
  return nullptr;
}

bool Comparison::Take(const simulation::RunState& replayed) {
  if (const simulation::RunState* recorded = Recorded(replayed.sample.tick)) Compare(*recorded, replayed);
  return !exhausted_;
}

void Comparison::Compare(simulation::RunState recorded, simulation::RunState replayed) {
  ++compared_;
  const auto columns = recording::SampleColumns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (!columns[i].repeatable || !recording_.HasColumn(i)) continue;
    std::visit(
        [&](auto place) {
          const auto was = place(recorded);
          const auto is = place(replayed);
          if (SameBits(was, is)) return;
          if (!difference_) difference_ = {replayed.sample.tick, columns[i].name, Shown(was), Shown(is)};
          if constexpr (std::is_same_v<decltype(was), const double>) {
            const double deviation = std::fabs(is - was);
            if (deviation > deviations_[i].largest) {
              deviations_[i].largest = deviation;
              deviations_[i].tick = replayed.sample.tick;
            }
          }
        },
        columns[i].place);
  }
}

std::vector<Deviation> Comparison::LargestDeviations() const {
  std::vector<Deviation> found;
  for (const Deviation& deviation : deviations_) {
    if (deviation.largest > 0.0) found.push_back(deviation);
  }
  return found;
}

}  // namespace servohil::run
