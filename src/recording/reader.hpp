#pragma once
/// Reads a recording: a finished one, a killed one, or one that is still being written.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "recording/recording.hpp"
#include "simulation/run_state.hpp"

namespace servohil::recording {

/// Not thread-safe. Every function throws UsageError, one line with file, dataset and rows, for what is
/// missing or damaged.
class RecordingReader {
 public:
  /// @param path  the directory, or servohil.h5 itself
  explicit RecordingReader(const std::filesystem::path& path);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  const std::filesystem::path& File() const noexcept;
  const RecordingAttributes& Attributes() const noexcept;
  /// Nothing: killed, or still being written.
  const std::optional<RecordingEnd>& End() const noexcept;
  /// Nothing was lost, and the end is on file.
  bool Complete() const noexcept;

  /// Samples that are whole: of columns of unequal length (killed while appending) the shortest counts. As of
  /// opening.
  std::uint64_t SampleCount() const noexcept;
  /// Whether it has this one of SampleColumns(): older recordings lack what was added later, ReadSamples()
  /// then leaves the default.
  bool HasColumn(std::size_t column) const noexcept;
  /// Fills `samples` from row `first` on. @return how many; 0 at the end. `due` is not recorded.
  std::size_t ReadSamples(std::uint64_t first, std::span<simulation::RunState> samples) const;

  std::vector<Stimulus> Stimuli() const;
  std::vector<RecordingGap> Gaps() const;

 private:
  struct Contents;
  std::unique_ptr<Contents> contents_;
};

}  // namespace servohil::recording
