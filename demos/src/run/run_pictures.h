/// Pictures of a run, off screen: a contact sheet of its moments, frames and a video.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scene_run.h"

namespace bsoil::scene {

/// Which pictures of a run are taken, and where they go.
struct RunPicturesDef {
    std::string folder;   ///< contact_sheet.png, frames/00000.png ..., video.mp4
    bool frames = false;  ///< one PNG for every 1/30 s, numbered from the scene's start
    bool video = false;   ///< this run's frames as a film, by ffmpeg
};

/// Whether ffmpeg, which makes the film, is in PATH.
bool has_film_maker();

/// Takes pictures while a run goes on. Each waits for the device.
class RunPictures {
  public:
    /// The run must outlive it. The error says why there can be no pictures here.
    static Result<std::unique_ptr<RunPictures>> create(const SceneRun& run,
                                                       const RunPicturesDef& def);
    ~RunPictures();
    /// As of ScenePicture.
    const std::vector<std::string>& notes() const;
    /// Before the first step and after every one. Writes the sheet at each of its moments.
    Status observe();
    /// After the last step: completes the sheet and writes the film.
    Status finish();

  private:
    struct Impl;
    explicit RunPictures(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace bsoil::scene
