#include "configuration/load_file.hpp"

#include <vector>

#include "base/error.hpp"
#include "configuration/csv.hpp"

namespace servohil::configuration {

model::LoadCurve ReadLoadCurve(const std::filesystem::path& file) {
  std::vector<model::LoadCurve::Point> points;
  for (const CsvRow& row : ReadCsv(file, "x3_in,p3_psi")) {
    if (!points.empty() && !(row.values[0] > points.back().x3_in)) {
      throw base::UsageError(file.string() + ":" + std::to_string(row.line) +
                             ": x3_in must rise from row to row; this one is not above the one before");
    }
    points.push_back({row.values[0], row.values[1]});
  }
  if (points.size() < 2 || points.size() > model::LoadCurve::kMaxPoints) {
    throw base::UsageError(file.string() + ": " + std::to_string(points.size()) + " rows, expected 2 to " +
                           std::to_string(model::LoadCurve::kMaxPoints));
  }
  return model::LoadCurve(points);
}

}  // namespace servohil::configuration
