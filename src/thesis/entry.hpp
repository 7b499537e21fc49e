#pragma once
/// One number or word that the thesis prints, beside ours.

#include <optional>
#include <string>
#include <vector>

#include "thesis/cases.hpp"

namespace servohil::thesis {

/// Why a printed value deviates, and what is right instead. The reason explains that deviation and no other:
/// our value has to meet `right`, which comes from a source other than this program.
struct Reason {
  std::string right;   ///< as many digits as are sure
  std::string errata;  ///< "1", "13, 14"; "new" where it is not among the numbered ones
  std::string text;    ///< one line
};

enum class Status { kAgrees, kExplained, kUnexplained };

struct Entry {
  std::string quantity;
  std::string unit;
  std::string printed;  ///< as the thesis prints it, "15.2e3"; its last digit sets the tolerance
  double ours = 0.0;
  std::string ours_word;  ///< instead of `ours` for a verdict
  std::optional<Reason> reason;
  std::string note = {};  ///< on what is printed, where the number itself is right

  bool IsWord() const { return !ours_word.empty(); }
  Status Judge() const;
  std::string Ours() const;
  /// ours - printed, as a share of printed; empty for words.
  std::string Deviation() const;
};

/// Entries that stand together in the source and have the same parameters.
struct Group {
  std::string where;                    ///< "Appendix B, coefficients of (B.18)"
  std::vector<std::string> settings;    ///< on top of the base configuration, "KEY=VALUE"
  std::vector<std::string> parameters;  ///< the full set, "KEY=VALUE"
  std::vector<Entry> entries;

  Group(std::string place, const Case& c)
      : where(std::move(place)), settings(c.settings), parameters(c.parameters) {}
  Entry& Number(std::string quantity, std::string unit, std::string printed, double ours,
                std::optional<Reason> reason = {}) {
    entries.push_back(
        {std::move(quantity), std::move(unit), std::move(printed), ours, "", std::move(reason)});
    return entries.back();
  }
  void Word(std::string quantity, std::string printed, std::string ours, std::optional<Reason> reason = {}) {
    entries.push_back({std::move(quantity), "", std::move(printed), 0.0, std::move(ours), std::move(reason)});
  }
};

using Groups = std::vector<Group>;

/// Half a unit of the last digit of a number as printed: 50 for "15.2e3".
double HalfDigit(const std::string& printed);

}  // namespace servohil::thesis
