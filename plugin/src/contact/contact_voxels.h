/// Surface elements of bodies against soil, from what the kernels found in voxels.
#pragma once

#include <optional>

#include "bsoil/work_threads.h"
#include "contact/free_surface.h"
#include "contact/shape_faces.h"
#include "contact/surface_pieces.h"

namespace bsoil {

/// A body whose contacts are looked at.
struct ContactBody {
    const SoilBody* input = nullptr;
    BodyFaces faces;
    const SurfaceSamples* surface = nullptr;  ///< null: area and place by the coverage field
    bool is_small = false;  ///< its samples meet the soil of one record: see collect_small_bodies
};

/// Makes one ContactVoxel of each face that meets soil in a voxel. Keeps its memory from one step
/// to the next.
class ContactVoxels {
  public:
    struct Request {
        std::span<const int32_t> words;             ///< of Buffer::result: see decode_contacts()
        std::span<const ContactBody> bodies;        ///< by index; without input: left out
        std::span<const int> body_ids;              ///< SoilBody::id by index
        std::span<const double> body_width_voxels;  ///< of each body's contact, by index
        const GridFrame* frame = nullptr;
        const Pose* world_to_grid = nullptr;  ///< of metres
        const ContactLawDef* law = nullptr;
        std::span<const double> wedge_length;  ///< see FreeSurface::Request
        std::span<const SurfaceWedge> wedges;  ///< the same
        const WorkThreads* threads = nullptr;
    };
    /// Surface words of the soil that a carrier holds (a body's index, or kOnGround). Of the ground
    /// asked for on any thread, of bodies on the caller's; one at a time.
    using TileWords = std::function<std::span<const int32_t>(int tile_x, int tile_y, int carrier)>;

    /// In an order that does not depend on the device or on threads.
    void make(const Request& request, const TileWords& words, std::vector<ContactVoxel>& out);

  private:
    struct Element;
    /// Puts them into `out` from out_count on, over what is there, and adds to it.
    void add_all(const Request& request, std::span<const ContactRecord> records, size_t& out_count,
                 std::vector<ContactVoxel>& out);
    void gather_pieces(const Request& request);
    void read_surface(const Request& request, std::span<const ContactRecord> carried,
                      const TileWords& words);
    size_t place_of(const ContactRecord& record) const;  ///< in records_
    static bool is_of_pieces(const Request& request, const ContactRecord& record);
    Element element_of(const Request& request, const ContactRecord& record) const;
    void add(const Request& request, const ContactRecord& record,
             std::vector<ContactVoxel>& out) const;
    size_t count_pieces(const Request& request, const ContactRecord& record) const;
    ContactVoxel* add_pieces(const Element& element, ContactVoxel* next) const;
    /// Where a body's load ends beside soil on the ground.
    struct LoadEnd {
        Vec3 at;           ///< on the edge of the face that it lies on; voxels, grid axes
        double sides = 0;  ///< length of the edge [voxels]
    };
    std::optional<LoadEnd> load_end(const Request& request, const ContactRecord& record) const;
    ContactVoxel load_side(const Element& element, const LoadEnd& end) const;
    void add_samples(const Element& element, std::vector<ContactVoxel>& out) const;
    void set_teeth(const ContactBody& body, const SurfacePiece& piece, ContactVoxel& contact) const;
    void add_faces(const Element& element, Vec3 face_normal, std::vector<ContactVoxel>& out) const;
    /// rise_m2: of a piece of the surface, covariance of height and place; without: one height.
    void finish(const Element& element, ContactVoxel& contact, Vec3 rise_m2 = {}) const;
    /// False: it is above the surface, or below it, as a whole.
    static bool keep_what_is_below(double depth_m, Vec3 rise_m2, Vec3 up, double voxel_m,
                                   ContactVoxel& contact);
    void bound_by_wedge(const Element& element, Vec3 at, Vec3 outward, double nearest,
                        ContactVoxel& contact) const;

    ContactOrder order_;
    std::vector<ContactRecord> records_;
    std::vector<std::vector<ContactVoxel>> chunks_;  ///< of those that are not pieces alone
    std::vector<size_t> chunk_starts_;               ///< in the list that they are joined to
    std::vector<SampledBody> sampled_;               ///< by body's index
    SurfacePieces pieces_;
    FreeSurface surface_;
};

}  // namespace bsoil
