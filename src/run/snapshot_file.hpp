#pragma once
/// Snapshots as files: JSON, every double with all its digits, with the configuration and DBC that they
/// belong to, a version and a checksum.

#include <filesystem>
#include <string>

#include "configuration/run_texts.hpp"
#include "emulator/simulation_task.hpp"

namespace servohil::run {

struct SnapshotFile {
  std::string program_version;
  emulator::Snapshot snapshot;
  configuration::RunTexts texts;
};

/// The state alone, as JSON in one line, and back. @throws UsageError when damaged, naming `place`
std::string SnapshotText(const emulator::Snapshot& snapshot);
emulator::Snapshot ParseSnapshotText(const std::string& text, const std::string& place);

/// Whole or not at all: written beside and renamed. @throws EnvironmentError
void WriteSnapshot(const std::filesystem::path& file, const SnapshotFile& snapshot);

/// @throws UsageError "FILE: ..." for what is no snapshot, of another version, or damaged
SnapshotFile ReadSnapshot(const std::filesystem::path& file);

}  // namespace servohil::run
