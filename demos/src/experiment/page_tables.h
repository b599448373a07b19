/// Tables of results as Markdown, and the blocks of a page that a command writes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "csv_table.h"
#include "experiment.h"

namespace bsoil::experiment {

/// How a column is shown: kilopascals and millimetres are what plates and wheels are read in.
struct Shown {
    std::string title;
    double factor = 1;
};
Shown shown(const std::string& column);

/// A figure with three digits, "-" for none.
std::string figure_text(const std::optional<double>& value, double factor);
/// A cell that tells rows apart: its number with up to five digits, or its text.
std::string key_text(const std::string& cell_text, double factor);

std::string table_row(const std::vector<std::string>& cells);
std::string table_head(const std::vector<std::string>& cells);

/// The largest page that is read.
inline constexpr size_t kPageBytesMost = size_t{16} << 20;

/// What stands between `<!-- bsoil COMMAND: NAME -->` and `<!-- end -->`.
struct Block {
    size_t begin = 0, end = 0;
};
/// The error says which marker the page lacks.
Result<Block> block_of(const std::string& page, const std::string& command,
                       const std::string& name);

/// Whether the file is a page with all these blocks: to be asked before what fills them is
/// measured.
Status has_blocks(const std::string& path, const std::string& command,
                  const std::vector<std::string>& names);

/// Puts the results of an experiment into its block of the page, `<!-- bsoil RIG: NAME -->`, NAME
/// that of its file: what is swept, and the columns that its expectations and plots name.
Result<std::string> update_results(std::string page, const Experiment& experiment,
                                   const CsvTable& results);

}  // namespace bsoil::experiment
