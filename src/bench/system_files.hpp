#pragma once
/// /proc, /sys and /dev below a root: "/" on the machine, a made-up tree in the tests.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace servohil::bench {

class SystemFiles {
 public:
  explicit SystemFiles(std::filesystem::path root = "/") : root_(std::move(root)) {}

  /// Whole text without the white space at its end; nothing when it cannot be read.
  /// @param path  without the leading slash: "proc/version"
  std::optional<std::string> Read(const std::string& path) const;
  /// Names in a folder, numbers in their order; none when it cannot be read.
  std::vector<std::string> List(const std::string& path) const;
  bool Exists(const std::string& path) const;
  bool IsFolder(const std::string& path) const;
  bool IsReadableAndWritable(const std::string& path) const;
  /// Where a symbolic link leads; empty when there is none.
  std::string LinkTarget(const std::string& path) const;

 private:
  std::filesystem::path root_;
};

/// The kernel's list of CPUs ("0-3,8") as numbers; what it cannot read, it leaves out.
std::vector<int> ParseCpuList(const std::string& list);
/// {0, 1, 2, 5} → "0-2,5".
std::string CpuListText(const std::vector<int>& cpus);

}  // namespace servohil::bench
