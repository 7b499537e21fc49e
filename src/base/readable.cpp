#include "base/readable.hpp"

#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "base/error.hpp"

namespace servohil::base {

std::string WhyUnreadable(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::file_type type = std::filesystem::status(file, error).type();
  if (type == std::filesystem::file_type::not_found) return "there is no such file";
  if (error) return error.message();
  if (type == std::filesystem::file_type::directory) return "is a directory";
  return access(file.c_str(), R_OK) == 0 ? std::string() : std::generic_category().message(errno);
}

void RequireReadable(const std::filesystem::path& file) {
  if (const std::string why = WhyUnreadable(file); !why.empty()) throw UsageError(file.string() + ": " + why);
}

bool IsDirectory(const std::filesystem::path& path) noexcept {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

}  // namespace servohil::base
