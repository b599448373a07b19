/// The volume in the window: the soil, or a field of it, to look into.
#pragma once

#include "world_picture.h"

namespace bsoil::viewer {

class VolumeLayer {
  public:
    /// Uploads voxels that have changed. The error says why there can be no volume, in each picture
    /// that is to have one.
    Status take(render::Renderer& renderer, const WorldPicture& picture) {
        placed_ = picture.volume;
        if (picture.voxels) taken_ = upload(renderer, *picture.voxels);
        return placed_ ? taken_ : Done{};
    }
    bool is_shown() const { return placed_ && id_.value != 0; }
    void append_to(render::View& view) const {
        if (!is_shown()) return;
        view.volumes.push_back(*placed_);
        view.volumes.back().volume = id_;
    }

  private:
    Status upload(render::Renderer& renderer, const render::VolumeData& voxels) {
        if (id_.value != 0) return renderer.set_volume(id_, voxels);
        auto added = renderer.add_volume(voxels);
        if (!added) return Error{added.error()};
        id_ = *added;
        return Done{};
    }

    render::VolumeId id_;
    Status taken_ = Done{};
    std::optional<render::Volume> placed_;
};

}  // namespace bsoil::viewer
