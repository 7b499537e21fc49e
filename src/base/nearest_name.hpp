#pragma once
/// "Did you mean ...?" for names that a user mistyped.

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace servohil::base {

/// Levenshtein distance, upper and lower case being the same: insertions, deletions and substitutions that
/// turn `a` into `b`.
inline std::size_t EditDistance(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = diagonal + (lower(a[i]) == lower(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

/// The candidate nearest to `wrong`; empty when none is near: more than a third of the letters (at least two)
/// would have to change. The first of several that are equally near.
inline std::string NearestName(std::string_view wrong, std::span<const std::string> candidates) {
  std::string nearest;
  std::size_t limit = std::max<std::size_t>(2, wrong.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    // At least as many letters change as one has more than the other.
    if (wrong.size() >= candidate.size() + limit || candidate.size() >= wrong.size() + limit) continue;
    const std::size_t distance = EditDistance(wrong, candidate);
    if (distance < limit && distance < std::max(wrong.size(), candidate.size())) {
      nearest = candidate;
      limit = distance;
    }
  }
  return nearest;
}

/// "a, b, c"
inline std::string Listed(std::span<const std::string> names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

/// "did you mean X?", or `otherwise` where no candidate is near.
inline std::string DidYouMean(std::string_view wrong, std::span<const std::string> candidates,
                              const std::string& otherwise) {
  const std::string nearest = NearestName(wrong, candidates);
  return nearest.empty() ? otherwise : "did you mean " + nearest + "?";
}

}  // namespace servohil::base
