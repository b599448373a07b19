/// Several pictures with captions on one sheet.
#pragma once

#include <array>
#include <span>
#include <string>

#include "bsoil/render/image.h"

#pragma GCC visibility push(default)
namespace bsoil::render {

/// How a sheet is laid out. Pictures fill it row by row.
struct ContactSheetDef {
    int columns = 4, rows = 2;  ///< 1 or more
    int cell_width = 640;       ///< pixels, 1 or more; the height follows from the first picture
    int gap = 6;                ///< pixels between pictures and around them, 0 or more
    int caption_scale = 2;      ///< size of a dot of the font [pixels]
};

/// Tiles pictures, scaled to the cells, with a caption in the upper left corner of each.
class ContactSheet {
  public:
    /// An empty sheet.
    explicit ContactSheet(const ContactSheetDef& def = {}) : def_(def) {}

    /// False when the sheet is full, the picture empty or not whole, or the layout out of its
    /// range; nothing is added then.
    bool add(const Image& image, const std::string& caption);
    /// "t = 1.25 s  text" for add().
    static std::string caption(double time_s, const std::string& text);
    /// Pictures added so far.
    int image_count() const { return image_count_; }
    /// The sheet so far; empty before the first picture.
    const Image& image() const { return sheet_; }

  private:
    ContactSheetDef def_;
    int image_count_ = 0;
    int cell_height_ = 0;
    Image sheet_;
};

/// A name and its colour (linear red, green, blue).
struct LegendEntry {
    std::string name;
    std::array<float, 3> color{};
};

/// Draws a swatch and a name for each entry, one below the other, in the lower left corner.
void draw_legend(Image& image, std::span<const LegendEntry> entries, int scale);

/// Draws a line of text in white on a dark bar, upper left corner at (x, y); clipped to the image,
/// which stays as it is unless it is whole.
/// The font has ASCII: other characters of UTF-8 become question marks.
void draw_caption(Image& image, int x, int y, const std::string& text, int scale);

}  // namespace bsoil::render
#pragma GCC visibility pop
