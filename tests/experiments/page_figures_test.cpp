// Figures within sentences are those of the tables that `bsoil validate` writes.
#include "experiment/page_figures.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace bsoil::experiment::page_figures_test {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

const std::string kTables =
    "<!-- bsoil validate: summary -->\n| data set | quantity | BulletSoil |\n|---|---|---|\n"
    "| [Wheel](#wheel) | pull | 31 %; 4.0 % of load |\n<!-- end -->\n"
    "<!-- bsoil validate: wheel -->\nGates:\n\n- met: it pulls\n\npull, N:\n\n"
    "| slip | load, N | measured | BulletSoil | error | Bekker | error "
    "|\n|---|---|---|---|---|---|---|\n"
    "| 0 | 20 | -1.0 | -3.0 | +200 % | 1 | - |\n| 0.2 | 21 | 2 | 1.5 | -25 % | 3 | +50 % |\n\n"
    "sinkage, mm:\n\n| slip | measured | BulletSoil |\n|---|---|---|\n| 0 | 7 | 8 |\n<!-- end "
    "-->\n";

std::string place(const std::string& name, const std::string& holds) {
    return "<!-- figure: " + name + " -->" + holds + "<!-- / -->";
}
std::string filled(const std::string& name) {
    const auto page = fill_figures("It is " + place(name, "old") + ".\n", kTables);
    return page ? *page : page.error();
}
std::string expected(const std::string& name, const std::string& figure) {
    return "It is " + place(name, figure) + ".\n";
}

TEST(PageFigures, are_taken_from_the_tables) {
    for (const auto& [name, figure] : {
             std::pair{"wheel / pull / 0 / BulletSoil", "-3.0"},
             std::pair{"wheel / sinkage / 0 / BulletSoil", "8"},
             std::pair{"wheel / pull / *, 21 / measured", "2"},
             std::pair{"wheel / pull / * / BulletSoil", "-3.0 to 1.5"},
             std::pair{"wheel / pull / 0.2 / BulletSoil error", "-25 %"},
             std::pair{"wheel / pull / 0.2 / Bekker error", "+50 %"},
             std::pair{"wheel / pull / 0 / Bekker error", "-"},
             std::pair{"wheel / pull / * / Bekker error", "+50 %"},
             std::pair{"summary / - / wheel, pull / BulletSoil", "31 %; 4.0 % of load"},
         }) {
        EXPECT_EQ(filled(name), expected(name, figure));
    }
}

TEST(PageFigures, that_no_table_has_are_an_error) {
    for (const char* name :
         {"wheel / torque / 0 / BulletSoil", "wheel / pull / 0.5 / BulletSoil",
          "wheel / pull / 0 / Wong", "blade / pull / 0 / BulletSoil", "wheel / pull / 0"}) {
        EXPECT_EQ(filled(name), "no table has \"" + std::string(name) + "\"; check the name");
    }
    EXPECT_NE(fill_figures("<!-- figure: wheel / pull / 0 / BulletSoil -->7", kTables)
                  .error()
                  .find("has no <!-- / -->"),
              std::string::npos);
}

TEST(PageFigures, of_the_pages_are_those_of_validation) {
    const std::string tables = text_of(BSOIL_SOURCE_DIR "/docs/validation.md");
    int page_count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(BSOIL_SOURCE_DIR "/docs")) {
        if (entry.path().extension() != ".md") continue;
        const std::string page = text_of(entry.path());
        if (!names_figures(page)) continue;
        ++page_count;
        const auto again = fill_figures(page, tables);
        ASSERT_TRUE(again) << entry.path() << ": " << again.error();
        EXPECT_TRUE(*again == page)
            << entry.path() << ": bsoil validate --sentences --document docs/validation.md";
    }
    EXPECT_GE(page_count, 2);
}

}  // namespace
}  // namespace bsoil::experiment::page_figures_test
