#include "run/p1_script.hpp"

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "configuration/csv.hpp"
#include "model/step.hpp"

namespace servohil::run {

namespace {

constexpr double kLongestRunS = 1e9;  // as long as a run may last

}  // namespace

std::vector<recording::Stimulus> ReadP1Script(const std::filesystem::path& file) {
  std::vector<recording::Stimulus> changes;
  double last_s = -1.0;
  for (const configuration::CsvRow& row : configuration::ReadCsv(file, "t_s,p1_psi")) {
    if (!(row.values[0] > last_s) || row.values[0] < 0.0 || row.values[0] > kLongestRunS) {
      throw base::UsageError(file.string() + ":" + std::to_string(row.line) +
                             ": t_s must be from 0 to 1e9 and rise from row to row");
    }
    last_s = row.values[0];
    // A time meant for a tick may lie beside it by rounding of its decimals.
    const double ticks = std::ceil(row.values[0] / model::kTickS - 1e-6);
    changes.push_back(CommandAfter(static_cast<std::uint64_t>(ticks), row.values[1]));
  }
  return changes;
}

recording::Stimulus CommandAfter(std::uint64_t ticks, double p1_psi) {
  recording::Stimulus stimulus{.tick = ticks + 1};
  stimulus.request.kind = simulation::Request::Kind::kCommand;
  stimulus.request.p1_psi = p1_psi;
  return stimulus;
}

}  // namespace servohil::run
