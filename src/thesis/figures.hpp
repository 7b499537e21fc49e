#pragma once
/// The thesis' figures that show results, recomputed: a CSV file each and figures.json, which
/// tools/plot_figures.py draws.

#include <filesystem>

#include "thesis/cases.hpp"

namespace servohil::thesis {

/// @throws EnvironmentError where the folder cannot be written
void WriteFigures(const MakeCase& make, const std::filesystem::path& folder);

/// Runs tools/plot_figures.py on the folder.
/// @throws EnvironmentError where Python or matplotlib is missing, or drawing failed
void DrawFigures(const std::filesystem::path& folder);

}  // namespace servohil::thesis
