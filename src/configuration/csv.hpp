#pragma once
/// Numeric CSV files with a header of known columns.

#include <filesystem>
#include <string>
#include <vector>

namespace servohil::configuration {

struct CsvRow {
  int line = 0;                ///< in the file, from 1
  std::vector<double> values;  ///< as many as columns, all finite
};

/// @param header  the first line that the file must have, e.g. "x3_in,p3_psi"
/// @throws UsageError "FILE:LINE: ..." for a missing file, another header, a field too many or few, not a
/// number
std::vector<CsvRow> ReadCsv(const std::filesystem::path& file, const std::string& header);

}  // namespace servohil::configuration
