#include "line_fit.h"

namespace bsoil::experiment {

std::optional<Line> fit_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                             const Eigen::VectorXd& weight) {
    const double sum = weight.sum();
    if (!(sum > 0)) return std::nullopt;
    const double x_mean = weight.dot(x) / sum, y_mean = weight.dot(y) / sum;
    const Eigen::ArrayXd dx = x.array() - x_mean, dy = y.array() - y_mean;
    const double spread = (weight.array() * dx.square()).sum();
    if (!(spread > 0)) return std::nullopt;
    const double slope = (weight.array() * dx * dy).sum() / spread;
    return Line{slope, y_mean - slope * x_mean};
}

}  // namespace bsoil::experiment
