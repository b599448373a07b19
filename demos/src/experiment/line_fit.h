/// Straight lines through points.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace bsoil::experiment {

/// y = slope x + offset
struct Line {
    double slope = 0, offset = 0;
};

/// The line that misses the points least, by the weighted mean of the squares; all vectors of one
/// length. Nothing where all points of weight have one x.
std::optional<Line> fit_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                             const Eigen::VectorXd& weight);

}  // namespace bsoil::experiment
