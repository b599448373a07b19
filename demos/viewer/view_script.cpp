#include "view_script.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <sstream>

namespace bsoil::viewer {
namespace {

/// Arguments of each action behind its name.
const std::map<std::string, size_t>& argument_counts() {
    static const std::map<std::string, size_t> counts{
        {"steps", 1}, {"click", 1}, {"slide", 2},  {"drag", 5},      {"wheel", 1},
        {"key", 1},   {"hold", 2},  {"frames", 1}, {"screenshot", 1}};
    return counts;
}

/// Words of a line; "two words" in quotes are one.
std::vector<std::string> words_of(const std::string& line) {
    std::vector<std::string> words;
    std::istringstream stream(line);
    while (stream >> std::ws && stream.peek() != EOF) {
        std::string word;
        if (stream.peek() == '"') {
            stream.get();
            std::getline(stream, word, '"');
        } else {
            stream >> word;
        }
        words.push_back(word);
    }
    return words;
}

float number_of(const std::string& word) { return std::strtof(word.c_str(), nullptr); }

constexpr int kFramesOfDrag = 6;

}  // namespace

Result<ViewScript> ViewScript::read(const std::string& path) {
    std::ifstream file(path);
    if (!file) return Error{path + ": cannot be read"};
    ViewScript script;
    script.path_ = path;
    int number = 0;
    for (std::string line; std::getline(file, line);) {
        ++number;
        Action action{number, words_of(line)};
        if (action.words.empty() || action.words[0][0] == '#') continue;
        const auto known = argument_counts().find(action.words[0]);
        if (known == argument_counts().end()) {
            return Error{fmt::format("{}:{}: no action `{}`", path, number, action.words[0])};
        }
        if (action.words.size() != known->second + 1) {
            return Error{fmt::format("{}:{}: `{}` takes {} words, {} given", path, number,
                                     action.words[0], known->second, action.words.size() - 1)};
        }
        script.actions_.push_back(std::move(action));
    }
    return script;
}

void ViewScript::fail(const Action& action, const std::string& why) {
    error_ = fmt::format("{}:{}: {}", path_, action.line, why);
    frames_.clear();
    next_ = actions_.size();
}

void ViewScript::expand(const Action& action, const Widgets& widgets, ImVec2 window) {
    const std::string& verb = action.words[0];
    const auto word = [&](size_t w) { return action.words[w]; };
    const auto number = [&](size_t w) { return number_of(action.words[w]); };
    std::vector<Frame> frames;
    const auto point_at = [&](ImVec2 at, int button = -1, float wheel = 0) {
        Frame frame;
        frame.pointer = at;
        frame.button = button;
        frame.wheel = wheel;
        frames.push_back(frame);
    };
    const auto press = [&](ImVec2 at, int button) {
        // Over it, down, up: ImGui sees each in a frame of its own.
        point_at(at);
        point_at(at, button);
        point_at(at, button);
        point_at(at);
        point_at(ImVec2{-1, -1});
    };
    if (verb == "click" || verb == "slide") {
        const auto place = widgets.place(word(1));
        if (!place) return fail(action, "no widget `" + word(1) + "` is shown");
        ImVec2 at{0.5f * (place->low.x + place->high.x), 0.5f * (place->low.y + place->high.y)};
        // Within the bar: its very ends belong to what is beside it.
        if (verb == "slide") {
            at.x =
                place->low.x + std::clamp(number(2), 0.01f, 0.99f) * (place->high.x - place->low.x);
        }
        press(at, 0);
    } else if (verb == "drag") {
        const int button = word(1) == "left" ? 0 : word(1) == "right" ? 1 : 2;
        const auto point = [&](float share) {
            return ImVec2{window.x * (number(2) + share * (number(4) - number(2))),
                          window.y * (number(3) + share * (number(5) - number(3)))};
        };
        point_at(point(0));
        for (int f = 0; f <= kFramesOfDrag; ++f) {
            point_at(point(static_cast<float>(f) / kFramesOfDrag), button);
        }
        point_at(point(1));
        point_at(ImVec2{-1, -1});
    } else if (verb == "wheel") {
        point_at(ImVec2{0.6f * window.x, 0.5f * window.y});
        point_at(ImVec2{0.6f * window.x, 0.5f * window.y}, -1, number(1));
    } else if (verb == "key" || verb == "hold") {
        if (SDL_GetScancodeFromName(word(1).c_str()) == SDL_SCANCODE_UNKNOWN) {
            return fail(action, "no key `" + word(1) + "`");
        }
        Frame down, held, up;
        down.key = up.key = word(1);
        down.key_down = true;
        frames.push_back(down);
        if (verb == "hold") {
            held.steps = std::max(1, static_cast<int>(number(2)));
            frames.emplace_back();
            frames.push_back(held);
        }
        frames.push_back(up);
        frames.emplace_back();
    } else if (verb == "steps") {
        Frame frame;
        frame.steps = std::max(1, static_cast<int>(number(1)));
        frames.push_back(frame);
        frames.emplace_back();
    } else if (verb == "frames") {
        frames.resize(static_cast<size_t>(std::clamp(number(1), 1.0f, 10000.0f)));
    } else {
        Frame frame;
        frame.screenshot = word(1);
        frames.emplace_back();  // what was asked for before is drawn by now
        frames.push_back(frame);
    }
    frames_.assign(frames.rbegin(), frames.rend());
}

bool ViewScript::begin_frame(Simulation& simulation, const Widgets& widgets, ImVec2 window) {
    if (frames_.empty()) {
        if (next_ >= actions_.size()) return false;
        const Action action = actions_[next_++];
        expand(action, widgets, window);
        if (frames_.empty()) return false;
    }
    const Frame frame = frames_.back();
    frames_.pop_back();
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = frame.pointer.x < 0 ? ImVec2{-FLT_MAX, -FLT_MAX} : frame.pointer;
    for (int b = 0; b < 3; ++b) io.MouseDown[b] = frame.button == b;
    io.MouseWheel = frame.wheel;
    if (!frame.key.empty()) {
        SDL_Event event{};
        event.type = frame.key_down ? SDL_KEYDOWN : SDL_KEYUP;
        event.key.state = frame.key_down ? SDL_PRESSED : SDL_RELEASED;
        event.key.keysym.scancode = SDL_GetScancodeFromName(frame.key.c_str());
        event.key.keysym.sym = SDL_GetKeyFromScancode(event.key.keysym.scancode);
        SDL_PushEvent(&event);
    }
    if (frame.steps > 0) simulation.make_steps(frame.steps);
    screenshot_ = frame.screenshot;
    return true;
}

void ViewScript::end_frame(const Window& window) {
    if (screenshot_.empty()) return;
    const Status written = render::write_png(window.read(), screenshot_);
    if (!written) {
        error_ = written.error();
        frames_.clear();
        next_ = actions_.size();
    }
    screenshot_.clear();
}

}  // namespace bsoil::viewer
