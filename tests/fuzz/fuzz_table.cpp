#include "experiment/csv_table.h"
#include "targets.h"

namespace bsoil::fuzz {

void fuzz_table(Bytes bytes) {
    const auto table = experiment::read_csv(scratch_file("table.csv", bytes));
    if (!table) return;
    for (size_t row = 0; row < table->rows.size(); ++row) {
        for (const std::string& column : table->columns) table->number(row, column);
    }
    // What is written is read again as it was.
    const std::string path = scratch_path("again.csv");
    require(experiment::write_csv(*table, path).ok(), "the table cannot be written");
    require(experiment::read_csv(path).ok(), "the table cannot be read again");
}

}  // namespace bsoil::fuzz
