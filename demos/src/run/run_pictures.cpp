#include "run_pictures.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <sstream>
#include <vector>

#include "baseline.h"
#include "bsoil/render/contact_sheet.h"
#include "bsoil/render/renderer.h"
#include "scene_picture.h"

namespace bsoil::scene {
namespace {

constexpr double kFrameS = 1.0 / 30;
constexpr double kAtTheEnd = std::numeric_limits<double>::infinity();  ///< a moment no step reaches
constexpr int kLegendScale = 4;  ///< legible on the contact sheet as well

}  // namespace

struct RunPictures::Impl {
    const SceneRun& run;
    RunPicturesDef def;
    std::unique_ptr<render::Renderer> renderer;
    std::optional<ScenePicture> picture;
    std::vector<double> moments_s;
    render::ContactSheet sheet;
    std::vector<render::LegendEntry> legend;  ///< the soil's materials
    int frame_first = 0, frame_next = 0;      ///< numbers of frames count from the scene's start

    Impl(const SceneRun& r, const RunPicturesDef& d)
        : run(r), def(d), moments_s(sample_moments_s(r)) {
        // Of a run that goes on the run before has pictured what lies behind.
        if (const long long last = r.step_count() - 1; last >= 0) {
            while (reached(frame_first * kFrameS, last)) ++frame_first;
            std::erase_if(moments_s, [&](double t_s) { return reached(t_s, last); });
        }
        frame_next = frame_first;
        if (moments_s.empty()) moments_s.push_back(kAtTheEnd);
        render::ContactSheetDef layout;
        layout.rows = (static_cast<int>(moments_s.size()) + layout.columns - 1) / layout.columns;
        sheet = render::ContactSheet(layout);
    }

    void build() {
        picture.emplace(run, *renderer);
        if (!run.has_soil()) return;
        for (const MaterialDef& material : run.soil().materials()) {
            legend.push_back({material.name, material.color});
        }
    }

    Result<render::Image> take() {
        auto image = renderer->render(picture->view());
        if (image && legend.size() > 1) render::draw_legend(*image, legend, kLegendScale);
        return image;
    }

    bool reached(double t_s, long long step_count) const {
        return static_cast<double>(step_count) * run.step_s() >= t_s - run.step_s() / 2;
    }
    bool reached(double t_s) const { return reached(t_s, run.step_count()); }

    /// The picture goes onto the sheet, which is written with what it has so far: who waits for a
    /// long run sees it begin.
    Status add_to_sheet(const render::Image& image) {
        sheet.add(image, render::ContactSheet::caption(run.time_s(), run.scene().title));
        return render::write_png(sheet.image(), def.folder + "/contact_sheet.png");
    }

    bool has_frames() const { return def.frames || def.video; }
    bool frame_is_due() const { return has_frames() && reached(frame_next * kFrameS); }

    /// Runs ffmpeg over the frames of this run: the folder may hold others of a longer one.
    Status encode() const {
        std::string input;
        for (const char c : def.folder) input += c == '%' ? std::string("%%") : std::string(1, c);
        input += "/frames/%05d.png";
        const std::string output = def.folder + "/video.mp4";
        if (frame_next == frame_first) {
            return Error{output + ": the run was too short for a frame; run it longer"};
        }
        std::vector<std::string> words;
        const auto add = [&words](const std::string& options) {
            std::istringstream each(options);
            for (std::string word; each >> word;) words.push_back(word);
        };
        // -nostdin: the input of a shell's loop is not ffmpeg's.
        add(fmt::format("ffmpeg -nostdin -y -loglevel error -framerate 30 -start_number {} -i",
                        frame_first));
        words.push_back(input);
        add(fmt::format("-frames:v {} -c:v libx264 -crf 18 -pix_fmt yuv420p",
                        frame_next - frame_first));
        words.push_back(output);
        std::vector<char*> arguments;
        for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
        arguments.push_back(nullptr);
        pid_t process = 0;
        int status = 1;
        if (posix_spawnp(&process, "ffmpeg", nullptr, nullptr, arguments.data(), environ) == 0) {
            const auto waited = [&] { return waitpid(process, &status, 0); };
            while (waited() < 0 && errno == EINTR) {
                // A signal that asks the run to end ends the wait, not the film.
            }
        }
        if (status != 0) {
            return Error{output +
                         ": ffmpeg failed, its own words are above; take the pictures in " +
                         def.folder + "/frames"};
        }
        return Done{};
    }
};

bool has_film_maker() {
    const char* path = std::getenv("PATH");
    std::stringstream folders(path ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        if (access((folder + "/ffmpeg").c_str(), X_OK) == 0) return true;
    }
    return false;
}

RunPictures::RunPictures(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RunPictures::~RunPictures() = default;

Result<std::unique_ptr<RunPictures>> RunPictures::create(const SceneRun& run,
                                                         const RunPicturesDef& def) {
    auto renderer = render::Renderer::create();
    if (!renderer) return Error{"no pictures: " + renderer.error()};
    auto impl = std::make_unique<Impl>(run, def);
    impl->renderer = std::move(*renderer);
    impl->build();
    std::error_code failed;
    if (impl->has_frames()) {
        std::filesystem::create_directories(def.folder + "/frames", failed);
    }
    if (failed) return Error{def.folder + "/frames: " + failed.message()};
    return std::unique_ptr<RunPictures>(new RunPictures(std::move(impl)));
}

const std::vector<std::string>& RunPictures::notes() const { return impl_->picture->notes(); }

Status RunPictures::observe() {
    Impl& m = *impl_;
    const bool frame = m.frame_is_due();
    const size_t next = static_cast<size_t>(m.sheet.image_count());
    const bool moment = next < m.moments_s.size() && m.reached(m.moments_s[next]);
    if (!frame && !moment) return Done{};
    const auto image = m.take();
    if (!image) return Error{image.error()};
    if (moment) {
        if (Status written = m.add_to_sheet(*image); !written) return written;
    }
    for (; m.frame_is_due(); ++m.frame_next) {  // a long step is several frames
        Status written = render::write_png(
            *image, fmt::format("{}/frames/{:05}.png", m.def.folder, m.frame_next));
        if (!written) return written;
    }
    return Done{};
}

Status RunPictures::finish() {
    Impl& m = *impl_;
    // Of a run that was cut short the sheet ends with how it stands then.
    if (static_cast<size_t>(m.sheet.image_count()) < m.moments_s.size()) {
        const auto image = m.take();
        if (!image) return Error{image.error()};
        if (Status written = m.add_to_sheet(*image); !written) return written;
    }
    return m.def.video ? m.encode() : Status(Done{});
}

}  // namespace bsoil::scene
