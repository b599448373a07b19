/// Tables of text with headings, read from and written to CSV files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bsoil/result.h"

namespace bsoil::experiment {

struct CsvTable {
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows;  ///< each as long as `columns`

    /// -1 where there is no such column.
    int column_index(const std::string& name) const;
    /// Nothing where the cell is no finite number.
    std::optional<double> number(size_t row, const std::string& column) const;
};

/// Commas, quoted cells, the first line are the headings; a byte order mark is left out. Short
/// lines are filled up with empty cells. The error names the file.
Result<CsvTable> read_csv(const std::string& path);
Status write_csv(const CsvTable& table, const std::string& path);

/// A number as it stands in tables, 6 digits.
std::string cell(double value);
/// Nothing where the text is no finite number; spaces around it do not count.
std::optional<double> number_in(const std::string& text);

}  // namespace bsoil::experiment
