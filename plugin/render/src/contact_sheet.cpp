#include "bsoil/render/contact_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_easy_font.h>
#pragma GCC diagnostic pop

namespace bsoil::render {
namespace {

constexpr uint8_t kBackground = 24;  ///< grey level of the sheet
constexpr int kCaptionMargin = 3;    ///< dots around the text
constexpr int kLineHeight = 9;       ///< dots of a line of the font, without descenders' gap

/// What the font has of a text in UTF-8: it reads beyond its tables for all but ASCII's characters.
std::string in_font(const std::string& text) {
    std::string result;
    for (const char c : text) {
        const auto byte = static_cast<uint8_t>(c);
        if (byte >= 0x80 && byte < 0xC0) continue;  // goes on with a character
        result += byte < ' ' ? ' ' : byte > '~' ? '?' : c;
    }
    return result;
}

/// Calls dot(x, y, width, height) for each rectangle of the text, in dots.
template <typename Draw>
void for_each_quad(std::string text, Draw draw) {
    struct Corner {
        float x, y, z;
        uint8_t color[4];
    };
    constexpr size_t kCornersPerCharacter = 80;  // above what the font needs for any character
    std::vector<Corner> corners(kCornersPerCharacter * (text.size() + 1));
    const int quad_count = stb_easy_font_print(0, 0, text.data(), nullptr, corners.data(),
                                               static_cast<int>(corners.size() * sizeof(Corner)));
    for (int q = 0; q < quad_count; ++q) {
        const Corner& low = corners[4 * q];
        const Corner& high = corners[4 * q + 2];
        draw(static_cast<int>(low.x), static_cast<int>(low.y), static_cast<int>(high.x - low.x),
             static_cast<int>(high.y - low.y));
    }
}

/// Calls paint(pixel) for the pixels of a rectangle that lie in the image.
template <typename Paint>
void paint_rectangle(Image& image, int x, int y, int width, int height, Paint paint) {
    if (!image.is_whole()) return;
    for (int j = std::max(0, y); j < std::min(image.height, y + height); ++j) {
        for (int i = std::max(0, x); i < std::min(image.width, x + width); ++i) {
            paint(image.pixel(i, j));
        }
    }
}

/// Mean colour of a rectangle of the source, borders weighted by their share.
std::array<uint8_t, 4> mean_color(const Image& image, double x0, double y0, double x1, double y1) {
    double sum[4] = {}, area = 0;
    for (int y = static_cast<int>(y0); y < std::min<double>(image.height, y1); ++y) {
        const double high = std::min(y1, y + 1.0) - std::max(y0, static_cast<double>(y));
        for (int x = static_cast<int>(x0); x < std::min<double>(image.width, x1); ++x) {
            const double wide = std::min(x1, x + 1.0) - std::max(x0, static_cast<double>(x));
            const uint8_t* p = image.pixel(x, y);
            for (int c = 0; c < 4; ++c) sum[c] += wide * high * p[c];
            area += wide * high;
        }
    }
    std::array<uint8_t, 4> mean{};
    for (size_t c = 0; c < 4; ++c) mean[c] = static_cast<uint8_t>(sum[c] / area + 0.5);
    return mean;
}

}  // namespace

void draw_caption(Image& image, int x, int y, const std::string& text, int scale) {
    std::string buffer = in_font(text);
    const int width = (stb_easy_font_width(buffer.data()) + 2 * kCaptionMargin) * scale;
    const int height = (kLineHeight + 2 * kCaptionMargin) * scale;
    paint_rectangle(image, x, y, width, height, [](uint8_t* pixel) {
        for (int c = 0; c < 3; ++c) pixel[c] = static_cast<uint8_t>(pixel[c] / 4);
    });
    const int left = x + kCaptionMargin * scale, top = y + kCaptionMargin * scale;
    for_each_quad(buffer, [&](int dot_x, int dot_y, int dots_wide, int dots_high) {
        paint_rectangle(image, left + dot_x * scale, top + dot_y * scale, dots_wide * scale,
                        dots_high * scale, [](uint8_t* pixel) { std::fill_n(pixel, 3, 245); });
    });
}

void draw_legend(Image& image, std::span<const LegendEntry> entries, int scale) {
    constexpr double kScreenGamma = 2.2;
    const int row = (kLineHeight + 2 * kCaptionMargin) * scale;
    int y = image.height - row * static_cast<int>(entries.size());
    for (const LegendEntry& entry : entries) {
        std::array<uint8_t, 3> color{};
        for (size_t c = 0; c < 3; ++c) {
            const double share = std::clamp<double>(entry.color[c], 0, 1);
            color[c] = static_cast<uint8_t>(255 * std::pow(share, 1 / kScreenGamma) + 0.5);
        }
        paint_rectangle(image, 0, y, row, row,
                        [&](uint8_t* pixel) { std::copy(color.begin(), color.end(), pixel); });
        draw_caption(image, row, y, entry.name, scale);
        y += row;
    }
}

std::string ContactSheet::caption(double time_s, const std::string& text) {
    char time[32];
    std::snprintf(time, sizeof(time), "t = %.2f s", time_s);
    return text.empty() ? time : std::string(time) + "   " + text;
}

bool ContactSheet::add(const Image& image, const std::string& caption) {
    if (def_.columns < 1 || def_.rows < 1 || def_.cell_width < 1 || def_.gap < 0) return false;
    if (image_count_ >= def_.columns * def_.rows || !image.is_whole()) return false;
    if (image_count_ == 0) {
        cell_height_ = std::max(1, def_.cell_width * image.height / image.width);
        sheet_.width = def_.columns * (def_.cell_width + def_.gap) + def_.gap;
        sheet_.height = def_.rows * (cell_height_ + def_.gap) + def_.gap;
        sheet_.rgba.assign(4 * static_cast<size_t>(sheet_.width) * sheet_.height, kBackground);
        for (size_t i = 3; i < sheet_.rgba.size(); i += 4) sheet_.rgba[i] = 255;
    }
    const int left = def_.gap + image_count_ % def_.columns * (def_.cell_width + def_.gap);
    const int top = def_.gap + image_count_ / def_.columns * (cell_height_ + def_.gap);
    const double step_x = static_cast<double>(image.width) / def_.cell_width;
    const double step_y = static_cast<double>(image.height) / cell_height_;
    for (int y = 0; y < cell_height_; ++y) {
        for (int x = 0; x < def_.cell_width; ++x) {
            const auto color =
                mean_color(image, x * step_x, y * step_y, (x + 1) * step_x, (y + 1) * step_y);
            std::copy(color.begin(), color.end(), sheet_.pixel(left + x, top + y));
        }
    }
    if (!caption.empty()) draw_caption(sheet_, left, top, caption, def_.caption_scale);
    ++image_count_;
    return true;
}

}  // namespace bsoil::render
