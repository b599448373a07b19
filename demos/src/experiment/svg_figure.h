/// Curves as an SVG picture, the same bytes on every machine: pictures that are kept in documents
/// change only when the figures do.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace bsoil::experiment {

struct SvgCurve {
    enum class Style { line, dashes, circles };
    Style style = Style::line;
    int color = 0;      ///< index; curves of one colour belong together
    std::string title;  ///< named once for each colour; empty: not named
    std::vector<std::pair<double, double>> points;
};

/// One pair of axes.
struct SvgPanel {
    std::string title, x_title, y_title;
    bool log_x = false, log_y = false;  ///< points that are not positive are left out
    std::vector<SvgCurve> curves;
};

/// What a style of curve stands for.
struct SvgStyleTitle {
    SvgCurve::Style style;
    std::string title;
};

/// Up to three panels beside each other, under a line that names the styles.
std::string svg_figure(const std::vector<SvgPanel>& panels,
                       const std::vector<SvgStyleTitle>& styles);

}  // namespace bsoil::experiment
