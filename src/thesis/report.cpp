#include "thesis/report.hpp"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

namespace servohil::thesis {
namespace {

using nlohmann::ordered_json;

const char* Word(Status status) {
  switch (status) {
    case Status::kAgrees:
      return "agrees";
    case Status::kExplained:
      return "explained";
    case Status::kUnexplained:
      return "UNEXPLAINED";
  }
  return "";
}

std::string Why(const Entry& e) {
  if (e.Judge() == Status::kAgrees) return e.note;
  if (!e.reason) return "no known reason";
  const std::string source =
      e.reason->errata == "new" ? "not in the errata: " : "errata " + e.reason->errata + ": ";
  if (e.Judge() == Status::kExplained) return source + e.reason->text + (e.note.empty() ? "" : "; " + e.note);
  return "should be " + e.reason->right + " (" + source + e.reason->text + ")";
}

/// With a column's worth of blanks after it; UTF-8 counts by character.
std::string Padded(const std::string& text, std::size_t width) {
  const auto characters = static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
  return text + std::string(characters < width ? width - characters : 0, ' ');
}

std::string Joined(const std::vector<std::string>& parts) {
  std::string all;
  for (const std::string& part : parts) all += (all.empty() ? "" : ", ") + part;
  return all;
}

void PrintCounts(const Summary& s) {
  std::printf("%d numbers and verdicts: %d agree, %d deviate for a known reason, %d deviate without\n",
              s.agree + s.explained + s.unexplained, s.agree, s.explained, s.unexplained);
}

}  // namespace

Summary Summarise(const Groups& groups) {
  Summary s;
  for (const Group& g : groups) {
    for (const Entry& e : g.entries) {
      const Status status = e.Judge();
      ++(status == Status::kAgrees ? s.agree : status == Status::kExplained ? s.explained : s.unexplained);
    }
  }
  return s;
}

void PrintText(const Groups& groups, const std::vector<std::string>& base) {
  std::printf(
      "Every printed number and verdict of the source: printed, ours, deviation. Parameters, unless the\n"
      "brackets under a heading say otherwise:\n");
  std::size_t column = 0;
  for (const std::string& parameter : base) {
    if (column > 0 && column + parameter.size() > 108) column = 0;
    std::printf("%s%s", column == 0 ? "\n  " : " ", parameter.c_str());
    column += parameter.size() + 1;
  }
  std::printf("\n");
  for (const Group& g : groups) {
    std::printf("\n%s\n  [%s]\n", g.where.c_str(), Joined(g.settings).c_str());
    for (const Entry& e : g.entries) {
      const std::string why = Why(e);
      std::printf("  %s %s %s %s %s%s%s\n",
                  Padded(e.quantity + (e.unit.empty() ? "" : " [" + e.unit + "]"), 46).c_str(),
                  Padded(e.printed, e.IsWord() ? 32 : 12).c_str(), Padded(e.Ours(), 12).c_str(),
                  Padded(e.Deviation(), 11).c_str(), Word(e.Judge()), why.empty() ? "" : "; ", why.c_str());
    }
  }
  std::printf("\n");
  PrintCounts(Summarise(groups));
}

void PrintMarkdown(const Groups& groups, const std::vector<std::string>& base) {
  std::printf("Parameters of every row, unless its heading says otherwise: %s.\n", Joined(base).c_str());
  for (const Group& g : groups) {
    std::printf(
        "\n### %s\n\n`%s`\n\n| | unit | printed | ours | deviation | | reason "
        "|\n|---|---|---|---|---|---|---|\n",
        g.where.c_str(), Joined(g.settings).c_str());
    for (const Entry& e : g.entries) {
      std::printf("| %s | %s | %s | %s | %s | %s | %s |\n", e.quantity.c_str(), e.unit.c_str(),
                  e.printed.c_str(), e.Ours().c_str(), e.Deviation().c_str(), Word(e.Judge()),
                  Why(e).c_str());
    }
  }
  std::printf("\n");
  PrintCounts(Summarise(groups));
}

void PrintJson(const Groups& groups, const std::vector<std::string>& base) {
  ordered_json out;
  out["parameters"] = base;
  out["groups"] = ordered_json::array();
  for (const Group& g : groups) {
    ordered_json entries = ordered_json::array();
    for (const Entry& e : g.entries) {
      ordered_json entry = {{"quantity", e.quantity}, {"unit", e.unit}, {"printed", e.printed}};
      entry["ours"] = e.IsWord() ? ordered_json(e.ours_word) : ordered_json(e.ours);
      if (!e.IsWord()) {
        const double printed = std::stod(e.printed);
        entry["deviation"] = e.ours - printed;
        entry["tolerance"] = HalfDigit(e.printed);
      }
      entry["status"] = e.Judge() == Status::kUnexplained ? "unexplained" : Word(e.Judge());
      if (e.Judge() != Status::kAgrees && e.reason) {
        entry["right"] = e.reason->right;
        entry["errata"] = e.reason->errata;
        entry["reason"] = e.reason->text;
      }
      if (!e.note.empty()) entry["note"] = e.note;
      entries.push_back(entry);
    }
    out["groups"].push_back(
        {{"where", g.where}, {"settings", g.settings}, {"parameters", g.parameters}, {"entries", entries}});
  }
  const Summary s = Summarise(groups);
  out["summary"] = {{"agree", s.agree}, {"explained", s.explained}, {"unexplained", s.unexplained}};
  std::cout << out.dump(2) << '\n';
}

}  // namespace servohil::thesis
