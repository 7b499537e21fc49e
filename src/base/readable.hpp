#pragma once
/// Files that the user names.

#include <filesystem>
#include <string>

namespace servohil::base {

/// Why this cannot be read as a file: "there is no such file", "is a directory", or what the system says
/// ("Permission denied"); empty: it can.
std::string WhyUnreadable(const std::filesystem::path& file);

/// @throws UsageError "FILE: why", when it cannot be read as a file
void RequireReadable(const std::filesystem::path& file);

bool IsDirectory(const std::filesystem::path& path) noexcept;

}  // namespace servohil::base
