#include "svg_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace bsoil::experiment {
namespace {

// All in pixels.
constexpr double kWidth = 400, kHeight = 300;  // of the axes
constexpr double kLeft = 64, kRight = 16, kTop = 24, kBottom = 44;
constexpr double kLine = 16;     // height of a line of text
constexpr double kSample = 36;   // length of a style's sample
constexpr double kLetter = 6.2;  // mean width of a letter, to place what follows a text
constexpr size_t kPanelsPerRow = 3;
constexpr double kTickCount = 6;  // about as many on an axis

// Okabe and Ito's colours, which colour-blind readers tell apart.
constexpr std::array<const char*, 7> kColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                             "#e69f00", "#56b4e9", "#000000"};
const char* color_of(int index) { return kColors[static_cast<size_t>(index) % kColors.size()]; }

std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '<') {
            out += "&lt;";
        } else if (c == '&') {
            out += "&amp;";
        } else {
            out += c;
        }
    }
    return out;
}

/// Values along an axis and where they stand, 0..1.
class Axis {
  public:
    Axis(const SvgPanel& panel, bool is_x) : log_(is_x ? panel.log_x : panel.log_y) {
        bool empty = true;
        for (const SvgCurve& curve : panel.curves) {
            for (const auto& [x, y] : curve.points) {
                if (!shown(is_x ? x : y)) continue;
                const double value = scaled(is_x ? x : y);
                low_ = empty ? value : std::min(low_, value);
                high_ = empty ? value : std::max(high_, value);
                empty = false;
            }
        }
        if (!log_ && low_ > 0) low_ = 0;
        if (!log_ && high_ < 0) high_ = 0;
        if (!(high_ > low_)) high_ = low_ + 1;
        const double room = 0.04 * (high_ - low_);  // so that no circle is cut
        if (log_ || low_ < 0) low_ -= room;
        high_ += room;
    }
    bool shown(double value) const { return !log_ || value > 0; }
    double share(double value) const { return (scaled(value) - low_) / (high_ - low_); }

    std::vector<double> ticks() const {
        std::vector<double> out;
        if (log_) {
            const bool few = high_ - low_ < 1.5;  // less than that many decades
            for (double decade = std::floor(low_); decade <= high_; ++decade) {
                for (const double digit : {1.0, 2.0, 5.0}) {
                    if ((few || digit == 1) && inside(decade + std::log10(digit))) {
                        out.push_back(std::pow(10, decade) * digit);
                    }
                }
            }
            return out;
        }
        const double raw = (high_ - low_) / kTickCount;
        const double power = std::pow(10, std::floor(std::log10(raw)));
        double step = 10 * power;
        for (const double digit : {5.0, 2.0, 1.0}) {
            if (digit * power >= raw) step = digit * power;
        }
        for (double i = std::ceil(low_ / step); i * step <= high_; ++i) {
            out.push_back(i == 0 ? 0 : i * step);
        }
        return out;
    }

  private:
    double scaled(double value) const { return log_ ? std::log10(value) : value; }
    bool inside(double scaled_value) const { return scaled_value >= low_ && scaled_value <= high_; }
    bool log_;
    double low_ = 0, high_ = 1;
};

std::string text_at(double x, double y, const std::string& anchor, const std::string& text,
                    const std::string& more = "") {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y,
                       anchor, more, escaped(text));
}

std::string path_of(const std::vector<std::pair<double, double>>& pixels, const SvgCurve& curve) {
    std::string out;
    if (curve.style == SvgCurve::Style::circles) {
        for (const auto& [x, y] : pixels) {
            out += fmt::format(
                "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"none\" stroke=\"{}\"/>\n", x,
                y, color_of(curve.color));
        }
        return out;
    }
    out = "<polyline fill=\"none\" stroke=\"";
    out += color_of(curve.color);
    out += curve.style == SvgCurve::Style::dashes ? "\" stroke-dasharray=\"6 4\" points=\""
                                                  : "\" stroke-width=\"2\" points=\"";
    for (const auto& [x, y] : pixels) out += fmt::format("{:.1f},{:.1f} ", x, y);
    return out + "\"/>\n";
}

/// The names of a panel's colours, each once.
std::vector<SvgCurve> named_colors(const SvgPanel& panel) {
    std::vector<SvgCurve> named;
    for (const SvgCurve& curve : panel.curves) {
        if (!curve.title.empty() &&
            std::none_of(named.begin(), named.end(),
                         [&](const SvgCurve& n) { return n.color == curve.color; })) {
            named.push_back(curve);
        }
    }
    return named;
}

std::string panel_at(double left, double top, const SvgPanel& panel) {
    const Axis x_axis(panel, true), y_axis(panel, false);
    const auto x_pixel = [&](double x) { return left + kWidth * x_axis.share(x); };
    const auto y_pixel = [&](double y) { return top + kHeight * (1 - y_axis.share(y)); };
    std::string out;
    for (const double tick : x_axis.ticks()) {
        const double x = x_pixel(tick);
        out += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}v{:.1f}\"/>\n", x, top, kHeight);
        out += text_at(x, top + kHeight + kLine, "middle", fmt::format("{:.4g}", tick));
    }
    for (const double tick : y_axis.ticks()) {
        const double y = y_pixel(tick);
        out += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}h{:.1f}\"/>\n", left, y, kWidth);
        out += text_at(left - 6, y + 4, "end", fmt::format("{:.4g}", tick));
    }
    out += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" fill=\"none\" "
        "stroke=\"#444\"/>\n",
        left, top, kWidth, kHeight);
    for (const SvgCurve& curve : panel.curves) {
        std::vector<std::pair<double, double>> pixels;
        for (const auto& [x, y] : curve.points) {
            if (x_axis.shown(x) && y_axis.shown(y)) pixels.push_back({x_pixel(x), y_pixel(y)});
        }
        if (!pixels.empty()) out += path_of(pixels, curve);
    }
    const double middle = left + kWidth / 2;
    out += text_at(middle, top + kHeight + 2.2 * kLine, "middle", panel.x_title);
    const double title_x = left - 48, title_y = top + kHeight / 2;
    out += text_at(title_x, title_y, "middle", panel.y_title,
                   fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", title_x, title_y));
    out += text_at(middle, top - 8, "middle", panel.title);
    double y = top + kHeight + kBottom;
    for (const SvgCurve& named : named_colors(panel)) {
        out += text_at(left, y + kLine / 2, "start", named.title,
                       fmt::format(" fill=\"{}\"", color_of(named.color)));
        y += kLine;
    }
    return out;
}

}  // namespace

std::string svg_figure(const std::vector<SvgPanel>& panels,
                       const std::vector<SvgStyleTitle>& styles) {
    const size_t columns = std::clamp<size_t>(panels.size(), 1, kPanelsPerRow);
    const size_t rows = (panels.size() + columns - 1) / columns;
    size_t names = 0;
    for (const SvgPanel& panel : panels) names = std::max(names, named_colors(panel).size());
    const double panel_width = kLeft + kWidth + kRight;
    const double panel_height = kTop + kHeight + kBottom + kLine * static_cast<double>(names + 1);
    const double width = panel_width * static_cast<double>(columns);
    const double height = 2 * kLine + panel_height * static_cast<double>(rows);
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
        "height=\"{1}\" font-family=\"sans-serif\" font-size=\"12\">\n"
        "<style>.grid{{stroke:#ddd}}</style>\n<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
        width, height);
    double x = kLeft;
    for (const SvgStyleTitle& style : styles) {
        const std::vector<std::pair<double, double>> sample{{x, kLine}, {x + kSample, kLine}};
        const SvgCurve grey{style.style, 6, "", {}};
        out += style.style == SvgCurve::Style::circles ? path_of({{x + kSample / 2, kLine}}, grey)
                                                       : path_of(sample, grey);
        out += text_at(x + kSample + 6, kLine + 4, "start", style.title);
        x += kSample + 30 + kLetter * static_cast<double>(style.title.size());
    }
    for (size_t i = 0; i < panels.size(); ++i) {
        out +=
            panel_at(kLeft + panel_width * static_cast<double>(i % columns),
                     2 * kLine + kTop + panel_height * static_cast<double>(i / columns), panels[i]);
    }
    return out + "</svg>\n";
}

}  // namespace bsoil::experiment
