#pragma once
/// Reader of the load table: CSV with the header `x3_in,p3_psi`, x3 strictly increasing.

#include <filesystem>

#include "model/load_curve.hpp"

namespace servohil::configuration {

/// @throws UsageError naming file, line, value and what would be right
model::LoadCurve ReadLoadCurve(const std::filesystem::path& file);

}  // namespace servohil::configuration
