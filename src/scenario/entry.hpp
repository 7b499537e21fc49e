#pragma once
/// One table of a scenario file: its keys are read one after the other; a mistake names file, line, key,
/// value and what would be right.

#include <toml++/toml.h>

#include <optional>
#include <string>
#include <vector>

namespace servohil::scenario {

class Entry {
 public:
  /// @param what  for messages: "[[command]]"; @param table must outlive it
  Entry(const std::string& file, std::string what, const toml::table& table)
      : file_(file), what_(std::move(what)), table_(table) {}

  int Line() const { return static_cast<int>(table_.source().begin.line); }
  bool Has(const std::string& key) const { return table_.contains(key); }
  const toml::table& Table() const { return table_; }

  // Each marks its key as known. All throw UsageError.
  std::optional<double> Number(const std::string& key, double minimum, double maximum,
                               const std::string& unit);
  double RequireNumber(const std::string& key, double minimum, double maximum, const std::string& unit);
  std::optional<std::string> Text(const std::string& key);
  std::string RequireText(const std::string& key);
  /// Two numbers, the second not below the first.
  std::optional<std::pair<double, double>> Range(const std::string& key, double minimum, double maximum,
                                                 const std::string& unit);
  const toml::node* Any(const std::string& key);

  /// Every key there is must have been asked for.
  void RefuseOthers() const;

  /// A mistake at one key's line, or the table's. @param right  "must be ..."
  [[noreturn]] void Fail(const std::string& key, const std::string& right) const;
  [[noreturn]] void FailWhole(const std::string& what_is_wrong) const;

 private:
  std::string PlaceOf(const std::string& key) const;

  const std::string& file_;
  std::string what_;
  const toml::table& table_;
  std::vector<std::string> known_;
};

}  // namespace servohil::scenario
