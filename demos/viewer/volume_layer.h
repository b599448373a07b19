/// The volume in the window: the soil, or a field of it, to look into.
#pragma once

#include "world_picture.h"

namespace bsoil::viewer {

class VolumeLayer {
  public:
    /// Uploads voxels that have changed. The error says why there can be no volume.
    Status take(render::Renderer& renderer, const WorldPicture& picture) {
        placed_ = picture.volume;
        if (!picture.voxels) return Done{};
        if (id_.value != 0) return renderer.set_volume(id_, *picture.voxels);
        auto added = renderer.add_volume(*picture.voxels);
        if (!added) return Error{added.error()};
        id_ = *added;
        return Done{};
    }
    bool is_shown() const { return placed_ && id_.value != 0; }
    void append_to(render::View& view) const {
        if (!is_shown()) return;
        view.volumes.push_back(*placed_);
        view.volumes.back().volume = id_;
    }

  private:
    render::VolumeId id_;
    std::optional<render::Volume> placed_;
};

}  // namespace bsoil::viewer
