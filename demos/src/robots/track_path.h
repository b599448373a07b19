/// The way of a track round its wheels: the taut belt about circles, and rigid links laid along it.
#pragma once

#include <cstddef>
#include <vector>

namespace bsoil::scene {

/// A point of the track's plane [m].
struct PlanePoint {
    double x = 0, y = 0;
};

/// A wheel seen along its axle.
struct TrackCircle {
    PlanePoint center_m;
    double radius_m = 0;
};

/// The boundary of the convex hull of circles, run through counterclockwise. Circles that it does
/// not touch are left out.
class TrackPath {
  public:
    /// At least one circle.
    explicit TrackPath(const std::vector<TrackCircle>& circles);

    double length_m() const { return length_m_; }
    /// The point `along_m` from the start; goes round as often as it takes.
    PlanePoint point(double along_m) const;
    /// How far the path turns about circle i [rad]; 0 where it does not touch it.
    double wrap_rad(size_t i) const { return wraps_rad_[i]; }

  private:
    struct Piece {
        TrackCircle circle;
        double from_rad = 0, turn_rad = 0;  ///< of the arc; the straight piece follows
        PlanePoint line_from_m, line_to_m;
        double arc_m = 0, line_m = 0;
    };
    std::vector<Piece> pieces_;
    std::vector<double> wraps_rad_;
    double length_m_ = 0;
};

/// Links of one length that close round the wheels.
struct TrackChain {
    std::vector<PlanePoint> pins_m;  ///< counterclockwise; link i reaches from pin i to pin i + 1
    double pitch_m = 0;              ///< between pins
    int sharp_wheel = -1;  ///< a wheel that these links are too long to bend round; -1: none
};

/// Lays `link_count` links, at least 3, round the wheels, at least 2. Their pins lie `pin_height_m`
/// above the face that runs on the wheels. No link cuts into a wheel, so the chain is slack by some
/// tenths of a per cent of its length.
TrackChain lay_track(const std::vector<TrackCircle>& wheels, double pin_height_m, int link_count);

}  // namespace bsoil::scene
