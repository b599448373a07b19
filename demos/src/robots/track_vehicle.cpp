#include "track_vehicle.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "track_path.h"

namespace bsoil::scene {
namespace {

/// Wheels whose centres lie further apart along the axle than this share of the link's width are
/// not in one plane.
constexpr double kInPlane = 1e-3;
/// Of guides: gap between guide and wheel, and thickness, as shares of the link's width.
constexpr double kGuideGap = 0.03, kGuideThickness = 0.05;
/// Of guides: length along the track, as a share of the pitch. Shorter than the link, so that those
/// of neighbours do not cross on the inside of a bend.
constexpr double kGuideLength = 0.6;
/// Wheels and links turning slower than this may fall asleep. Bullet's own threshold, 1 rad/s, is
/// meant for bodies of a metre; a link of 0.1 m is then held awake by 5 cm/s of its edge.
constexpr double kSleepRadS = 3;

/// The rotation whose columns are these unit axes.
Quat rotation_of(Vec3 x, Vec3 y, Vec3 z) {
    Eigen::Matrix3d columns;
    columns << x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z;
    const Eigen::Quaterniond q(columns);
    return {q.x(), q.y(), q.z(), q.w()};
}

/// Makes one track. Positions are in the hull's frame until they are placed.
class TrackBuilder {
  public:
    TrackBuilder(Scene& scene, const TrackItem& track, std::vector<SchemaError>& errors)
        : scene_(scene), track_(track), errors_(errors) {}

    void build() {
        BodyItem& hull = *std::find_if(scene_.bodies.begin(), scene_.bodies.end(),
                                       [&](const BodyItem& b) { return b.name == track_.hull; });
        if (!hull.multibody.empty()) {
            return error(
                track_.where("hull"),
                "\"{}\" is a link of a multibody, which a track cannot run on; name a [[body]]",
                track_.hull);
        }
        const size_t error_count = errors_.size();
        set_axes();
        check_wheels();
        check_links();
        if (errors_.size() != error_count) return;
        const TrackChain chain = lay_links();
        if (errors_.size() != error_count) return;
        if (hull.group.empty()) hull.group = hull.name + "/links";
        hull_pose_ = hull.pose;
        group_ = hull.group;
        for (const TrackWheelItem& wheel : track_.wheels) add_wheel(wheel);
        add_links(chain);
    }

  private:
    template <typename... Args>
    void error(SourcePosition at, fmt::format_string<Args...> text, Args&&... args) {
        errors_.push_back({at, fmt::format(text, std::forward<Args>(args)...)});
    }

    /// x and y of the track's plane such that the track's lower side runs along x.
    void set_axes() {
        if (length(track_.axis) < 1e-6) {
            return error(track_.where("axis"), "the axis must have a length");
        }
        axle_ = track_.axis * (1 / length(track_.axis));
        const Vec3 along = std::abs(axle_.x) < 0.9 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
        x_ = along - dot(along, axle_) * axle_;
        x_ = x_ * (1 / length(x_));
        y_ = cross(x_, axle_);
    }

    void check_wheels() {
        const std::vector<TrackWheelItem>& wheels = track_.wheels;
        if (wheels.size() < 2) {
            return error(track_.at, "a track needs at least two [[track.wheel]]");
        }
        std::map<std::string, int> first_line;
        for (size_t i = 0; i < wheels.size(); ++i) {
            const TrackWheelItem& wheel = wheels[i];
            const auto [first, inserted] = first_line.emplace(wheel.name, wheel.where("name").line);
            if (!inserted) {
                error(wheel.where("name"),
                      "a [[track.wheel]] named \"{}\" stands in line {} already; rename one",
                      wheel.name, first->second);
            }
            const double aside_m = dot(wheel.position_m - wheels[0].position_m, axle_);
            if (std::abs(aside_m) > kInPlane * track_.link_width_m) {
                error(wheel.where("position_m"),
                      "wheel \"{}\" stands {:.4g} m beside the plane of wheel \"{}\"; move it",
                      wheel.name, std::abs(aside_m), wheels[0].name);
            }
            for (size_t k = 0; k < i; ++k) {
                const double apart_m = length(wheel.position_m - wheels[k].position_m);
                const double least_m = wheel.radius_m + wheels[k].radius_m;
                if (apart_m < least_m) {
                    error(wheel.where("position_m"),
                          "wheels \"{}\" and \"{}\" overlap: {:.4g} m apart, radii {:g} m and "
                          "{:g} m; move one",
                          wheels[k].name, wheel.name, apart_m, wheels[k].radius_m, wheel.radius_m);
                }
            }
            if (wheel.max_velocity_rad_s && wheel.motor_torque_n_m <= 0) {
                error(wheel.where("max_velocity_deg_s"),
                      "wheel \"{}\" has no motor; give it `motor_torque_n_m`", wheel.name);
            }
        }
    }

    void check_links() {
        if ((track_.link_count > 0) == track_.pitch_m.has_value()) {
            error(track_.at, "give `link_count` or `pitch_m`");
        }
        if (track_.link_count == 1 || track_.link_count == 2) {
            error(track_.where("link_count"), "{} links do not go round anything; give more",
                  track_.link_count);
        }
        if (track_.guide_height_m <= 0) return;
        double widest_m = 0;
        for (const TrackWheelItem& wheel : track_.wheels) {
            widest_m = std::max(widest_m, wheel.width_m);
        }
        const double least_m = widest_m / (1 - 2 * (kGuideGap + kGuideThickness));
        if (track_.link_width_m < least_m) {
            error(
                track_.where("link_width_m"),
                "links {:g} m wide have no room for guides beside wheels of {:g} m: `link_width_m` "
                "at least {:.4g}, or `guide_height_m = 0`",
                track_.link_width_m, widest_m, least_m);
        }
        guide_y_m_ = widest_m / 2 + (kGuideGap + kGuideThickness / 2) * track_.link_width_m;
    }

    TrackChain lay_links() {
        std::vector<TrackCircle> circles;
        for (const TrackWheelItem& wheel : track_.wheels) {
            circles.push_back(
                {{dot(wheel.position_m, x_), dot(wheel.position_m, y_)}, wheel.radius_m});
        }
        const double pin_height_m = track_.link_thickness_m / 2;
        int link_count = track_.link_count;
        if (track_.pitch_m) {
            std::vector<TrackCircle> belt = circles;
            for (TrackCircle& circle : belt) circle.radius_m += pin_height_m;
            const double wanted = TrackPath(belt).length_m() / *track_.pitch_m;
            if (wanted < 3 || wanted > 1000) {
                error(track_.where("pitch_m"),
                      "the way round the wheels, {:.4g} m, takes {:.4g} links of {:g} m, must be 3 "
                      ".. 1000",
                      wanted * *track_.pitch_m, wanted, *track_.pitch_m);
                return {};
            }
            link_count = static_cast<int>(std::lround(wanted));
        }
        TrackChain chain = lay_track(circles, pin_height_m, link_count);
        const SourcePosition at =
            track_.pitch_m ? track_.where("pitch_m") : track_.where("link_count");
        if (chain.sharp_wheel >= 0) {
            const TrackWheelItem& wheel = track_.wheels[static_cast<size_t>(chain.sharp_wheel)];
            error(at,
                  "{} links of {:.4g} m do not bend round wheel \"{}\" of radius {:g} m; make them "
                  "shorter",
                  link_count, chain.pitch_m, wheel.name, wheel.radius_m);
        } else if (track_.grouser_height_m > 0 && track_.grouser_thickness_m > chain.pitch_m) {
            error(
                track_.where("grouser_thickness_m"),
                "grousers of {:g} m are thicker than links of {:.4g} m are long; make them thinner",
                track_.grouser_thickness_m, chain.pitch_m);
        }
        return chain;
    }

    Vec3 on_plane(PlanePoint p) const {
        return p.x * x_ + p.y * y_ + dot(track_.wheels[0].position_m, axle_) * axle_;
    }

    /// A body that moves along with the hull at the start.
    BodyItem moving(const SceneItem& source, const std::string& name, const Pose& in_hull) const {
        const BodyItem& hull = *scene_.find_body(track_.hull);
        BodyItem body;
        static_cast<SceneItem&>(body) = source;
        body.name = track_.name + '/' + name;
        body.pose = hull_pose_ * in_hull;
        body.velocity_m_s = hull.velocity_m_s + cross(hull.angular_velocity_rad_s,
                                                      body.pose.position - hull_pose_.position);
        body.angular_velocity_rad_s = hull.angular_velocity_rad_s;
        body.sleep_rad_s = kSleepRadS;
        return body;
    }

    /// A motor that nothing drives holds against its torque: dry friction.
    JointItem hinge(const SceneItem& source, const std::string& name, const std::string& parent,
                    const std::string& child, Vec3 point_in_hull, double torque_n_m) const {
        JointItem joint;
        static_cast<SceneItem&>(joint) = source;
        joint.name = track_.name + '/' + name;
        joint.kind = "hinge";
        joint.parent = parent;
        joint.child = child;
        joint.point_m = transform(hull_pose_, point_in_hull);
        joint.axis = rotate(hull_pose_.rotation, axle_);
        joint.motor_torque_n_m = torque_n_m;
        return joint;
    }

    void add_wheel(const TrackWheelItem& wheel) {
        BodyItem body = moving(wheel, wheel.name, {wheel.position_m, rotation_of(x_, -y_, axle_)});
        body.shape.shape = "cylinder";
        body.shape.radius_m = wheel.radius_m;
        body.shape.height_m = wheel.width_m;
        body.mass_kg = wheel.mass_kg;
        body.friction = wheel.friction;
        body.color = wheel.color;
        const bool is_driven = wheel.motor_torque_n_m > 0;
        JointItem joint = hinge(wheel, wheel.name, track_.hull, body.name, wheel.position_m,
                                is_driven ? wheel.motor_torque_n_m : wheel.bearing_torque_n_m);
        joint.max_velocity = wheel.max_velocity_rad_s;
        scene_.bodies.push_back(std::move(body));
        scene_.joints.push_back(std::move(joint));
    }

    static ShapeItem box(Vec3 size_m, Vec3 position_m) {
        ShapeItem item;
        item.shape = "box";
        item.size_m = size_m;
        item.pose.position = position_m;
        return item;
    }

    /// The solids of a link: x along the track, y along the axles, z inwards.
    std::vector<ShapeItem> link_solids(double pitch_m) const {
        const double half_m = track_.link_thickness_m / 2;
        std::vector<ShapeItem> solids{
            box({pitch_m, track_.link_width_m, track_.link_thickness_m}, {})};
        if (track_.grouser_height_m > 0) {
            solids.push_back(
                box({track_.grouser_thickness_m, track_.link_width_m, track_.grouser_height_m},
                    {0, 0, -half_m - track_.grouser_height_m / 2}));
        }
        if (track_.guide_height_m > 0) {
            for (const double side : {-1.0, 1.0}) {
                solids.push_back(box({kGuideLength * pitch_m, kGuideThickness * track_.link_width_m,
                                      track_.guide_height_m},
                                     {0, side * guide_y_m_, half_m + track_.guide_height_m / 2}));
            }
        }
        return solids;
    }

    void add_links(const TrackChain& chain) {
        const size_t count = chain.pins_m.size();
        const int digits = count < 100 ? 2 : count < 1000 ? 3 : 4;
        const auto numbered = [&](const char* what, size_t i) {
            return fmt::format("{}_{:0{}}", what, i + 1, digits);
        };
        for (size_t i = 0; i < count; ++i) {
            const Vec3 from = on_plane(chain.pins_m[i]),
                       to = on_plane(chain.pins_m[(i + 1) % count]);
            const Vec3 along = (to - from) * (1 / length(to - from));
            BodyItem link =
                moving(track_, numbered("link", i),
                       {(from + to) * 0.5, rotation_of(along, axle_, cross(along, axle_))});
            link.shape.shape = "compound";
            link.parts = link_solids(chain.pitch_m);
            link.mass_kg = track_.link_mass_kg;
            link.friction = track_.friction;
            link.tool_friction = track_.tool_friction;
            link.tool_adhesion_pa = track_.tool_adhesion_pa;
            link.color = track_.color;
            link.group = group_;
            scene_.bodies.push_back(std::move(link));
            scene_.joints.push_back(
                hinge(track_, numbered("pin", i),
                      track_.name + '/' + numbered("link", (i + count - 1) % count),
                      track_.name + '/' + numbered("link", i), from, track_.pin_torque_n_m));
        }
    }

    Scene& scene_;
    const TrackItem& track_;
    std::vector<SchemaError>& errors_;
    Vec3 axle_, x_, y_;  // in the hull's frame
    double guide_y_m_ = 0;
    Pose hull_pose_;
    std::string group_;
};

}  // namespace

void add_track(Scene& scene, const TrackItem& track, std::vector<SchemaError>& errors) {
    TrackBuilder(scene, track, errors).build();
}

}  // namespace bsoil::scene
