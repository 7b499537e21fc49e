#pragma once
/// The comparison as text, JSON and Markdown.

#include "thesis/entry.hpp"

namespace servohil::thesis {

struct Summary {
  int agree = 0;
  int explained = 0;
  int unexplained = 0;
};

Summary Summarise(const Groups& groups);

void PrintText(const Groups& groups, const std::vector<std::string>& base);
void PrintMarkdown(const Groups& groups, const std::vector<std::string>& base);
void PrintJson(const Groups& groups, const std::vector<std::string>& base);

}  // namespace servohil::thesis
