/// Stands in for run_pictures.cpp where the project is built with BULLETSOIL_RENDER=OFF.
#include "run_pictures.h"

namespace bsoil::scene {

struct RunPictures::Impl {
    std::vector<std::string> notes;
};

bool has_film_maker() { return false; }

RunPictures::RunPictures(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RunPictures::~RunPictures() = default;

Result<std::unique_ptr<RunPictures>> RunPictures::create(const SceneRun&, const RunPicturesDef&) {
    return Error{"no pictures: built with BULLETSOIL_RENDER=OFF; build with it ON"};
}
const std::vector<std::string>& RunPictures::notes() const { return impl_->notes; }
Status RunPictures::observe() { return Done{}; }
Status RunPictures::finish() { return Done{}; }

}  // namespace bsoil::scene
