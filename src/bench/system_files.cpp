#include "bench/system_files.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

namespace servohil::bench {
namespace {

bool NumbersInOrder(const std::string& a, const std::string& b) {
  return a.size() != b.size() ? a.size() < b.size() : a < b;
}

}  // namespace

std::optional<std::string> SystemFiles::Read(const std::string& path) const {
  std::ifstream in(root_ / path);
  if (!in) return std::nullopt;
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad()) return std::nullopt;
  text.erase(text.find_last_not_of(" \t\r\n") + 1);  // npos + 1 = 0: all of it
  return text;
}

std::vector<std::string> SystemFiles::List(const std::string& path) const {
  std::vector<std::string> names;
  std::error_code error;
  for (auto entry = std::filesystem::directory_iterator(root_ / path, error);
       !error && entry != std::filesystem::directory_iterator(); entry.increment(error))
    names.push_back(entry->path().filename().string());
  std::sort(names.begin(), names.end(), NumbersInOrder);
  return names;
}

bool SystemFiles::Exists(const std::string& path) const {
  std::error_code error;
  return std::filesystem::exists(root_ / path, error);
}

bool SystemFiles::IsFolder(const std::string& path) const {
  std::error_code error;
  return std::filesystem::is_directory(root_ / path, error);
}

bool SystemFiles::IsReadableAndWritable(const std::string& path) const {
  return access((root_ / path).c_str(), R_OK | W_OK) == 0;
}

std::string SystemFiles::LinkTarget(const std::string& path) const {
  std::error_code error;
  return std::filesystem::read_symlink(root_ / path, error).string();
}

std::vector<int> ParseCpuList(const std::string& list) {
  std::vector<int> cpus;
  std::istringstream in(list);
  for (std::string range; std::getline(in, range, ',');) {
    int first = 0;
    const char* end = range.data() + range.size();
    const auto [after, error] = std::from_chars(range.data(), end, first);
    if (error != std::errc{}) continue;
    int last = first;
    if (after != end && *after == '-') std::from_chars(after + 1, end, last);
    for (int cpu = first; cpu <= last; ++cpu) cpus.push_back(cpu);
  }
  return cpus;
}

std::string CpuListText(const std::vector<int>& cpus) {
  std::string text;
  for (std::size_t i = 0; i < cpus.size();) {
    std::size_t last = i;
    while (last + 1 < cpus.size() && cpus[last + 1] == cpus[last] + 1) ++last;
    if (!text.empty()) text += ',';
    text += std::to_string(cpus[i]);
    if (last != i) text.append("-").append(std::to_string(cpus[last]));
    i = last + 1;
  }
  return text;
}

}  // namespace servohil::bench
