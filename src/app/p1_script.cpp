#include "p1_script.hpp"

#include <cmath>
#include <string>

#include "servohil/app/csv.hpp"
#include "servohil/error.hpp"
#include "servohil/model/step.hpp"

namespace servohil::app {

std::vector<P1Change> ReadP1Script(const std::filesystem::path& file) {
  std::vector<P1Change> changes;
  double last_s = -1.0;
  for (const CsvRow& row : ReadCsv(file, "t_s,p1_psi")) {
    if (!(row.values[0] > last_s) || row.values[0] < 0.0) {
      throw UsageError(file.string() + ":" + std::to_string(row.line) +
                       ": t_s must be 0 or more and rise from row to row");
    }
    last_s = row.values[0];
    // A time meant for a tick may lie beside it by rounding of its decimals.
    const double ticks = std::ceil(row.values[0] / model::kTickS - 1e-6);
    changes.push_back({static_cast<std::uint64_t>(ticks), row.values[1]});
  }
  return changes;
}

}  // namespace servohil::app
