#include <charconv>
#include <fstream>
#include <iostream>

#include "base/error.hpp"
#include "base/formatted.hpp"
#include "linear/analysis.hpp"

namespace servohil::linear {
namespace {

struct Axis {
  std::string key;
  double low = 0.0;
  double high = 0.0;
  int count = 41;

  double At(int i) const { return low + (high - low) * i / (count - 1); }
};

template <typename T>
bool Parse(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

/// KEY=LOW:HIGH[:N]
Axis ParseAxis(const std::string& text) {
  constexpr int kMost = 1001;
  const std::size_t equals = text.find('=');
  const std::size_t first = equals == std::string::npos ? equals : text.find(':', equals);
  const std::size_t second = first == std::string::npos ? first : text.find(':', first + 1);
  Axis axis;
  const bool good =
      first != std::string::npos && equals > 0 &&
      Parse(text.substr(equals + 1, first - equals - 1), axis.low) &&
      Parse(text.substr(first + 1, second == std::string::npos ? second : second - first - 1), axis.high) &&
      (second == std::string::npos || Parse(text.substr(second + 1), axis.count));
  if (!good || !(axis.low < axis.high) || axis.count < 2 || axis.count > kMost) {
    throw base::UsageError("--map " + text + ": expected KEY=LOW:HIGH[:N], LOW below HIGH, N 2 to " +
                           std::to_string(kMost) + ", e.g. servo.bulk_modulus_psi=60e3:230e3:41");
  }
  axis.key = text.substr(0, equals);
  return axis;
}

std::string Setting(const std::string& key, double value) {
  return key + "=" + base::Formatted("%.17g", value);
}

}  // namespace

void WriteMap(const std::filesystem::path& configuration, const std::vector<std::string>& settings,
              const std::vector<std::string>& axes, const LinearOptions& options, const std::string& output) {
  const Axis first = ParseAxis(axes.at(0));
  const Axis second = ParseAxis(axes.at(1));
  if (first.key == second.key) throw base::UsageError("--map: " + first.key + " is on both axes");
  const auto load = [&](double a, double b) {
    std::vector<std::string> all = settings;
    all.push_back(Setting(first.key, a));
    all.push_back(Setting(second.key, b));
    return configuration::LoadConfiguration(configuration, all).model;
  };
  // A range that the configuration refuses is a mistake, before the file is touched.
  for (const double a : {first.low, first.high})
    for (const double b : {second.low, second.high}) load(a, b);

  std::ofstream file;
  if (output != "-") file.open(output);
  std::ostream& out = output == "-" ? std::cout : file;
  if (!out) throw base::EnvironmentError(output + ": cannot be written");
  out << first.key << ',' << second.key << ",largest_real_1_s,damping,frequency_rad_s,status\n";
  for (int i = 0; i < first.count; ++i) {
    for (int j = 0; j < second.count; ++j) {
      out << base::Formatted("%.9g,%.9g,", first.At(i), second.At(j));
      try {
        const LinearPoint point = LinearPointOf(load(first.At(i), second.At(j)), options);
        const PoleList poles = Poles(point.system);
        const Pole& least = poles.LeastDamped();
        out << base::Formatted("%.9g,%.9g,%.9g,", poles.LargestRealPart(), least.Damping(),
                               least.FrequencyRadS())
            << (poles.LargestRealPart() < 0.0 ? "stable\n" : "unstable\n");
      } catch (const base::UsageError&) {  // no steady state with these parameters
        out << ",,,no steady state\n";
      }
    }
  }
  if (!out.flush()) throw base::EnvironmentError(output + ": writing failed (disk full?)");
}

}  // namespace servohil::linear
