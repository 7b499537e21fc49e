#include "configuration/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include "base/error.hpp"
#include "base/readable.hpp"

namespace servohil::configuration {
namespace {

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

double ParseField(std::string_view field, const std::string& place) {
  const std::string_view text = Trimmed(field);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    throw base::UsageError(place + ": \"" + std::string(text) + "\" is not a number");
  }
  return value;
}

}  // namespace

std::vector<CsvRow> ReadCsv(const std::filesystem::path& file, const std::string& header) {
  base::RequireReadable(file);
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  if (Trimmed(line) != header) {
    throw base::UsageError(file.string() + ":1: header is \"" + std::string(Trimmed(line)) +
                           "\", expected \"" + header + "\"");
  }
  const auto columns = static_cast<std::size_t>(std::count(header.begin(), header.end(), ',') + 1);
  std::vector<CsvRow> rows;
  for (int number = 2; std::getline(in, line); ++number) {
    std::string_view rest = Trimmed(line);
    if (rest.empty()) continue;
    const std::string place = file.string() + ":" + std::to_string(number);
    CsvRow row{number, {}};
    for (bool more = true; more;) {
      const std::size_t comma = rest.find(',');
      more = comma != std::string_view::npos;
      row.values.push_back(ParseField(rest.substr(0, comma), place));
      if (more) rest.remove_prefix(comma + 1);
    }
    if (row.values.size() != columns) {
      throw base::UsageError(place + ": " + std::to_string(row.values.size()) + " fields, expected " +
                             std::to_string(columns) + " (" + header + ")");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace servohil::configuration
