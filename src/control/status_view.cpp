#include "control/status_view.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "base/formatted.hpp"

namespace servohil::control {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kWidth = 80;
constexpr double kBarCells = 40.0;

/// One line, cut where the screen ends; nothing that would move the cursor.
std::string Line(std::string text) {
  const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; };
  std::replace_if(text.begin(), text.end(), is_control, ' ');
  if (text.size() > kWidth) text = text.substr(0, kWidth - 3) + "...";
  return text + '\n';
}

double Number(const Json& object, const char* name) {
  const auto value = object.find(name);
  return value != object.end() && value->is_number() ? value->get<double>() : std::nan("");
}

bool Flag(const Json& object, const char* name, bool missing) {
  const auto value = object.find(name);
  return value != object.end() && value->is_boolean() ? value->get<bool>() : missing;
}

std::string Text(const Json& value) {
  return value.is_string() ? value.get<std::string>()
                           : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// "[######------]" of what fills the range 0 to `full`.
std::string Bar(double value, double full) {
  const double cells = full > 0.0 ? std::clamp(value / full, 0.0, 1.0) * kBarCells : 0.0;
  const auto filled = static_cast<std::size_t>(std::isfinite(cells) ? std::lround(cells) : 0);
  return "[" + std::string(filled, '#') + std::string(static_cast<std::size_t>(kBarCells) - filled, '-') +
         "]";
}

std::string Gauge(const Json& status, const char* label, const char* name, const char* unit, double full) {
  const double value = Number(status, name);
  return Line(base::Formatted("%-4s %10.4g %-5s ", label, value, unit) + Bar(value, full) +
              base::Formatted(" %g", full));
}

/// A list with commas, on as many lines as it needs.
std::string Wrapped(const std::string& name, const std::vector<std::string>& parts) {
  std::string text;
  std::string line = base::Formatted("%-10s", name.c_str());
  for (const std::string& part : parts) {
    if (line.size() + part.size() + 2 > kWidth) {
      text += Line(line);
      line = std::string(10, ' ');
    }
    line += " " + part + (part == parts.back() ? "" : ",");
  }
  return text + Line(line);
}

/// The command's supervision, and what of its frames was refused.
std::string Safety(const Json& safety) {
  if (safety.empty()) return {};
  std::string text = Line(
      base::Formatted("safety     %s (%s), %.0f times lost, %.0f trips", safety.value("state", "").c_str(),
                      safety.value("cause", "").c_str(), Number(safety, "losses"), Number(safety, "trips")));
  const Json frames = safety.value("frames", Json::object());
  std::vector<std::string> parts = {base::Formatted("%.0f valid", Number(frames, "commands"))};
  for (const auto& [name, count] : frames.items()) {
    if (name != "commands" && count != 0) parts.push_back(Text(count) + " " + name);
  }
  return text + Wrapped("frames", parts);
}

std::string Warnings(const Json& status) {
  std::vector<std::string> warnings;
  if (!Flag(status, "timing_valid", true)) {
    warnings.push_back(base::Formatted("timing INVALID: %.0f late ticks, worst %.3f ms",
                                       Number(status, "late_ticks"), Number(status, "worst_lateness_ms")));
  }
  if (Flag(status, "model_fault", false))
    warnings.emplace_back("the model left its domain: last good values");
  if (Flag(status, "stuck", false)) warnings.emplace_back("the piston is held by friction or a stop");
  std::string text;
  for (const std::string& warning : warnings) text += Line("warning    " + warning);
  return text;
}

std::string Faults(const Json& faults) {
  std::string text;
  for (const Json& one : faults.value("faults", Json::array())) {
    std::string line = base::Formatted("fault      %-24s %3.0f %%", one.value("fault", "").c_str(),
                                       100.0 * one.value("share", 0.0));
    const Json parameters = one.value("parameters", Json::object());
    for (const auto& [name, value] : parameters.items()) line += " " + name + "=" + Text(value);
    text += Line(line);
  }
  return text.empty() ? "fault      none\n" : text;
}

/// A list of objects: one line each.
std::string List(const std::string& name, const Json& items) {
  std::string text;
  for (const Json& item : items) {
    std::string line;
    for (const auto& [key, value] : item.items())
      line += " " + (key == "name" ? "" : key + " ") + Text(value);
    text += Line(base::Formatted("%-10s", name.c_str()) + line);
  }
  return text;
}

/// What is wrong with each bus; of its counts those that are not zero, so that they fit.
std::string Buses(const Json& status) {
  std::string text;
  for (const Json& bus : status.value("buses", Json::array())) {
    std::string line = "bus        " + bus.value("bus", "") + "  " + bus.value("state", "");
    for (const Json& fault : bus.value("faults", Json::array())) line += ", " + Text(fault);
    std::string counts;
    for (const auto& [name, value] : bus.items()) {
      if (value.is_number() && value != 0) counts += "  " + name + " " + Text(value);
    }
    text += Line(line);
    if (!counts.empty()) text += Line("          " + counts);
  }
  return text;
}

std::string Rest(const Json& status) {
  static const std::set<std::string> kShown = {"id",
                                               "result",
                                               "mode",
                                               "tick",
                                               "time_s",
                                               "p1_psi",
                                               "p2_psi",
                                               "p3_psi",
                                               "p4_psi",
                                               "p8_psi",
                                               "x3_in",
                                               "v3_in_s",
                                               "stroke_in",
                                               "stuck",
                                               "timing_valid",
                                               "model_fault",
                                               "late_ticks",
                                               "worst_lateness_ms",
                                               "active_faults",
                                               "buses",
                                               "safety",
                                               "command_age_s"};
  std::string text;
  for (const auto& [name, value] : status.items()) {
    if (kShown.contains(name)) continue;
    text +=
        value.is_array() ? List(name, value) : Line(base::Formatted("%-10s ", name.c_str()) + Text(value));
  }
  return text;
}

}  // namespace

std::string StatusView(const Json& status, const Json& faults) {
  const double supply_psi = Number(status, "p2_psi");
  const std::string mode = status.value("mode", "");
  std::string text = Line(base::Formatted("servohil   %-12s t %.1f s (tick %.0f)", mode.c_str(),
                                          Number(status, "time_s"), Number(status, "tick")));
  text += Gauge(status, "x3", "x3_in", "in", Number(status, "stroke_in"));
  text += Line(base::Formatted("v3   %10.4g in/s", Number(status, "v3_in_s")));
  text += Gauge(status, "P1", "p1_psi", "psi", supply_psi);
  text += Gauge(status, "P3", "p3_psi", "psi", supply_psi);
  text += Gauge(status, "P4", "p4_psi", "psi", supply_psi);
  text += Gauge(status, "P8", "p8_psi", "psi", supply_psi);
  text += Line(base::Formatted("P2   %10.4g psi", supply_psi));
  text += mode == "WAITING" ? "command    none yet\n"
                            : Line(base::Formatted("command    %.4g s old", Number(status, "command_age_s")));
  return text + Safety(status.value("safety", Json::object())) + Buses(status) + Rest(status) +
         Faults(faults) + Warnings(status);
}

}  // namespace servohil::control
