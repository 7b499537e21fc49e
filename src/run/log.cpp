#include "run/log.hpp"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/sinks/systemd_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <memory>
#include <sstream>

namespace servohil::run {

bool StandardErrorIsJournal() {
  const char* journal = std::getenv("JOURNAL_STREAM");  // "DEVICE:INODE" of the stream that systemd has made
  struct stat error {};
  if (journal == nullptr || fstat(STDERR_FILENO, &error) != 0) return false;
  return journal == std::to_string(error.st_dev) + ":" + std::to_string(error.st_ino);
}

void SetUpLog() {
  if (StandardErrorIsJournal()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("", std::make_shared<spdlog::sinks::systemd_sink_mt>("servohil")));
    return;
  }
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("", std::make_shared<spdlog::sinks::stderr_sink_mt>()));
  spdlog::set_pattern("servohil: %l: %v");
}

void TellEachLine(const std::string& text) {
  const char* begin = StandardErrorIsJournal() ? "<3>" : "servohil: ";
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) std::cerr << begin << line << '\n';
}

}  // namespace servohil::run
