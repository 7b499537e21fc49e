// In place of src/configuration/load_file.cpp: any file has a load curve, so that fuzzers read none of
// this machine. file_fuzz has the real one.

#include <vector>

#include "configuration/load_file.hpp"

namespace servohil::configuration {

/// Two curves, by the length of the name: one may lie above the other.
model::LoadCurve ReadLoadCurve(const std::filesystem::path& file) {
  const double more_psi = file.native().size() % 2 == 0 ? 0.0 : 1.0;
  const std::vector<model::LoadCurve::Point> points = {
      {1.0, 67.5 + more_psi}, {1.75, 56.5 + more_psi}, {8.0, 103.0 + more_psi}};
  return model::LoadCurve(points);
}

}  // namespace servohil::configuration
