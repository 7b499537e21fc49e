#include "can/dbc/dbc.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>

#include "base/error.hpp"
#include "base/nearest_name.hpp"
#include "can/dbc/dbc_check.hpp"

namespace servohil::can {
namespace {

template <typename Items>
const typename Items::value_type* FindByName(const Items& items, std::string_view name) {
  const auto at =
      std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.name == name; });
  return at == items.end() ? nullptr : &*at;
}

/// "; the nearest is 'X'", or which there are.
template <typename Items>
std::string Suggestion(const Items& items, std::string_view wrong) {
  std::vector<std::string> names;
  names.reserve(items.size());
  for (const auto& item : items) names.push_back(item.name);
  const std::string nearest = base::NearestName(wrong, names);
  if (!nearest.empty()) return "; the nearest is '" + nearest + "'";
  if (names.empty()) return "; there are none";
  std::string list = "; there are " + std::to_string(names.size()) + ":";
  constexpr std::size_t kMaxListed = 6;
  for (std::size_t i = 0; i < std::min(names.size(), kMaxListed); ++i) list += " " + names[i];
  return names.size() > kMaxListed ? list + " ..." : list;
}

/// By its byte order mark, or each second byte of the first letters being 0.
bool IsUtf16(const std::string& text) {
  if (text.size() < 2) return false;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  return byte(0) + byte(1) == 0xFF + 0xFE || byte(0) == 0 || byte(1) == 0;
}

[[noreturn]] void FailMissing(const Databases& databases, std::string_view message_name) {
  std::string names;
  std::vector<Message> all;
  for (const Database& file : databases.files) {
    names += (names.empty() ? "" : ", ") + file.file;
    all.insert(all.end(), file.messages.begin(), file.messages.end());
  }
  throw base::UsageError(names + ": no message '" + std::string(message_name) + "'" +
                         Suggestion(all, message_name));
}

}  // namespace

const Signal* Message::FindSignal(std::string_view signal_name) const {
  return FindByName(signals, signal_name);
}

const Signal* Message::Selector() const {
  const auto at = std::find_if(signals.begin(), signals.end(), [](const Signal& signal) {
    return signal.multiplexing == Multiplexing::kSelector;
  });
  return at == signals.end() ? nullptr : &*at;
}

const Message* Database::FindMessage(std::string_view message_name) const {
  return FindByName(messages, message_name);
}

const Message& Database::RequireMessage(std::string_view message_name) const {
  const Message* message = FindMessage(message_name);
  if (message == nullptr) {
    throw base::UsageError(file + ": no message '" + std::string(message_name) + "'" +
                           Suggestion(messages, message_name));
  }
  CheckUsable(*this, *message);
  return *message;
}

const Signal& Database::RequireSignal(const Message& message, std::string_view signal_name) const {
  const Signal* signal = message.FindSignal(signal_name);
  if (signal == nullptr) {
    throw base::UsageError(file + ":" + std::to_string(message.line) + ": message '" + message.name +
                           "' has no signal '" + std::string(signal_name) + "'" +
                           Suggestion(message.signals, signal_name));
  }
  return *signal;
}

Databases::Found Databases::RequireMessage(std::string_view message_name) const {
  const auto at = std::find_if(files.begin(), files.end(), [&](const Database& file) {
    return file.FindMessage(message_name) != nullptr;
  });
  if (at == files.end()) FailMissing(*this, message_name);
  const Message& message = at->RequireMessage(message_name);
  for (const Database& other : files) {
    if (&other == &*at) continue;
    for (const Message& twin : other.messages) {
      if (twin.name != message.name && (twin.id != message.id || twin.extended != message.extended)) continue;
      throw base::UsageError(other.file + ":" + std::to_string(twin.line) + ": message '" + twin.name +
                             "' has the " + (twin.name == message.name ? "name" : "id") + " of '" +
                             message.name + "' in " + at->file + ":" + std::to_string(message.line) +
                             ": leave one of the two files out");
    }
  }
  return {&*at, &message};
}

Databases ReadDbcs(const std::vector<std::string>& files) {
  Databases databases;
  for (const std::string& file : files) databases.files.push_back(ReadDbc(file));
  return databases;
}

Database ReadDbc(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const int error = errno;
  if (!stream) {
    throw base::UsageError(file.string() + ": cannot be read: " + std::generic_category().message(error));
  }
  std::ostringstream text;
  if (stream.peek() != std::ifstream::traits_type::eof()) text << stream.rdbuf();
  if (stream.bad() || text.bad())
    throw base::UsageError(file.string() + ": cannot be read: not a regular file?");
  if (IsUtf16(text.str()))
    throw base::UsageError(file.string() +
                           ": is UTF-16, expected UTF-8 or Windows-1252: save it as one of these");
  return ParseDbc(text.str(), file.string());
}

}  // namespace servohil::can
