#pragma once
/// Snapshots as files: JSON, every double with all its digits, with the configuration and DBC that they
/// belong to, a version and a checksum.

#include <filesystem>
#include <string>

#include "servohil/app/run_texts.hpp"
#include "servohil/app/simulation_task.hpp"

namespace servohil::app {

struct SnapshotFile {
  std::string program_version;
  Snapshot snapshot;
  RunTexts texts;
};

/// The state alone, as JSON in one line, and back. @throws UsageError when damaged, naming `place`
std::string SnapshotText(const Snapshot& snapshot);
Snapshot ParseSnapshotText(const std::string& text, const std::string& place);

/// Whole or not at all: written beside and renamed. @throws EnvironmentError
void WriteSnapshot(const std::filesystem::path& file, const SnapshotFile& snapshot);

/// @throws UsageError "FILE: ..." for what is no snapshot, of another version, or damaged
SnapshotFile ReadSnapshot(const std::filesystem::path& file);

}  // namespace servohil::app
