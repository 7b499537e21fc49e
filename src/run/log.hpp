#pragma once
/// Where the log goes: standard error, or the systemd journal when standard error is connected to it.

#include <string>

namespace servohil::run {

/// Standard error is the systemd journal: it knows the time, the program and, told by each line, how urgent
/// it is.
bool StandardErrorIsJournal();

/// Before the first line.
void SetUpLog();

/// Mistakes, a line for each, to standard error without the log.
void TellEachLine(const std::string& text);

}  // namespace servohil::run
