#include "bsoil/render/contact_sheet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "temporary_file.h"

namespace bsoil::render::contact_sheet_test {
namespace {

Image plain(int width, int height, uint8_t level) {
    return {width, height, std::vector<uint8_t>(4 * static_cast<size_t>(width * height), level)};
}

TEST(ContactSheet, tiles_pictures_row_by_row) {
    ContactSheet sheet({.columns = 2, .rows = 2, .cell_width = 32, .gap = 4});
    EXPECT_TRUE(sheet.add(plain(64, 32, 100), ""));
    EXPECT_TRUE(sheet.add(plain(64, 32, 150), ""));
    EXPECT_TRUE(sheet.add(plain(48, 48, 200), ""));
    const Image& image = sheet.image();
    EXPECT_EQ(image.width, 2 * 32 + 3 * 4);
    EXPECT_EQ(image.height, 2 * 16 + 3 * 4);
    EXPECT_EQ(image.pixel(4, 4)[0], 100);
    EXPECT_EQ(image.pixel(4 + 36 + 31, 4 + 15)[0], 150);
    EXPECT_EQ(image.pixel(4 + 16, 4 + 20 + 8)[0], 200);
    EXPECT_LT(image.pixel(1, 1)[0], 50);
}

TEST(ContactSheet, refuses_more_than_it_holds_and_empty_pictures) {
    ContactSheet sheet({.columns = 1, .rows = 1, .cell_width = 16});
    EXPECT_FALSE(sheet.add({}, ""));
    EXPECT_TRUE(sheet.add(plain(16, 16, 9), ""));
    EXPECT_FALSE(sheet.add(plain(16, 16, 9), ""));
    EXPECT_EQ(sheet.image_count(), 1);
}

TEST(ContactSheet, captions_are_legible_and_clipped) {
    EXPECT_EQ(ContactSheet::caption(1.25, "blade"), "t = 1.25 s   blade");
    EXPECT_EQ(ContactSheet::caption(2, ""), "t = 2.00 s");
    Image image = plain(100, 40, 120);
    draw_caption(image, 0, 0, "t = 1.25 s   far too long a text for so small a picture", 2);
    const auto level_count = [&](uint8_t level) {
        int count = 0;
        for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x) count += image.pixel(x, y)[1] == level;
        }
        return count;
    };
    EXPECT_GT(level_count(245), 100);  // letters
    EXPECT_GT(level_count(30), 1000);  // the bar behind them
    EXPECT_EQ(image.pixel(50, 39)[1], 120);
}

TEST(ContactSheet, what_the_font_lacks_is_a_question_mark) {
    const auto drawn = [](const std::string& text) {
        Image image = plain(200, 40, 120);
        draw_caption(image, 0, 0, text, 1);
        return image.rgba;
    };
    EXPECT_EQ(drawn("B\xC3\xB6schung\t\xE2\x89\xA4 ~\x7F"), drawn("B?schung ? ~?"));
    EXPECT_EQ(drawn("\xFF"), drawn("?"));
}

TEST(ContactSheet, a_layout_out_of_its_range_takes_no_picture) {
    EXPECT_FALSE(ContactSheet({.columns = -1, .rows = -1}).add(plain(16, 16, 9), ""));
    EXPECT_FALSE(ContactSheet({.cell_width = -4}).add(plain(16, 16, 9), ""));
    EXPECT_FALSE(ContactSheet({.gap = -700}).add(plain(16, 16, 9), ""));
    EXPECT_FALSE(ContactSheet().add({16, 16, {}}, ""));
    Image part{100, 40, {}};
    draw_caption(part, 0, 0, "text", 2);
    EXPECT_TRUE(part.rgba.empty());
}

TEST(ContactSheet, a_legend_has_a_swatch_and_a_name_for_each_entry) {
    Image image = plain(200, 100, 120);
    const LegendEntry entries[] = {{"sand", {1, 1, 1}}, {"loam", {0, 0, 0}}};
    draw_legend(image, entries, 2);
    // Two rows of 15 dots at the bottom, the swatch as wide as it is high.
    EXPECT_EQ(image.pixel(5, 45)[0], 255);
    EXPECT_EQ(image.pixel(5, 75)[0], 0);
    EXPECT_EQ(image.pixel(5, 35)[0], 120);  // above them nothing
    EXPECT_EQ(image.pixel(32, 42)[0], 30);  // the bar behind a name
}

TEST(Image, png_that_cannot_be_written_is_named) {
    const Status bad = write_png(plain(4, 4, 0), "/no/such/folder/picture.png");
    ASSERT_FALSE(bad);
    EXPECT_NE(bad.error().find("/no/such/folder/picture.png"), std::string::npos);
    const TemporaryFile file("picture.png");
    ASSERT_TRUE(write_png(plain(4, 4, 0), file.path()));
    EXPECT_GT(std::filesystem::file_size(file.path()), 50u);
}

TEST(Image, pictures_that_are_not_whole_are_refused) {
    const TemporaryFile file("part.png");
    EXPECT_FALSE(write_png({4, 4, std::vector<uint8_t>(63)}, file.path()));
    EXPECT_FALSE(write_jpeg({4, 4, {}}, file.path()));
    EXPECT_FALSE(write_jpeg(plain(65536, 1, 0), file.path()));
    EXPECT_FALSE(std::filesystem::exists(file.path()));
}

TEST(Image, jpeg_is_small_and_begins_as_one) {
    EXPECT_FALSE(write_jpeg(plain(4, 4, 0), "/no/such/folder/picture.jpg"));
    EXPECT_FALSE(write_jpeg(Image{}, TemporaryFile("empty.jpg").path()));
    const TemporaryFile file("picture.jpg");
    ASSERT_TRUE(write_jpeg(plain(64, 64, 90), file.path()));
    EXPECT_LT(std::filesystem::file_size(file.path()), 2000u);
    std::ifstream in(file.path(), std::ios::binary);
    EXPECT_EQ(in.get(), 0xff);  // start of image
    EXPECT_EQ(in.get(), 0xd8);
}

}  // namespace
}  // namespace bsoil::render::contact_sheet_test
