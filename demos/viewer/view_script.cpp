#include "view_script.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>

namespace bsoil::viewer {
namespace {

/// Words behind each action's name: t a text, c a count, f a fraction or another number, b a button
/// of the mouse.
const std::map<std::string, std::string>& arguments_of() {
    static const std::map<std::string, std::string> arguments{
        {"steps", "c"}, {"click", "t"}, {"slide", "tf"}, {"drag", "bffff"},  {"wheel", "f"},
        {"key", "t"},   {"hold", "tc"}, {"frames", "c"}, {"screenshot", "t"}};
    return arguments;
}

constexpr const char* kButtons[] = {"left", "right", "middle"};
constexpr float kCountMost = 100'000;  ///< steps or frames of an action

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

/// None where the word as a whole is no number.
std::optional<float> number_in(const std::string& word) {
    float number = 0;
    const char* end = word.data() + word.size();
    const auto read = std::from_chars(word.data(), end, number);
    if (read.ec != std::errc() || read.ptr != end || !std::isfinite(number)) return {};
    return number;
}

/// Of a word that was checked.
float number_of(const std::string& word) { return *number_in(word); }
int count_of(const std::string& word) { return static_cast<int>(number_of(word)); }

int button_of(const std::string& word) {
    const auto* found = std::find(std::begin(kButtons), std::end(kButtons), word);
    return found == std::end(kButtons) ? -1 : static_cast<int>(found - std::begin(kButtons));
}

/// What a word should have been; empty where it is that.
std::string mistake_in(const std::string& word, char kind) {
    const std::optional<float> number = number_in(word);
    if (kind == 'f' && !number) return fmt::format("`{}` is no number", word);
    if (kind == 'b' && button_of(word) < 0) {
        return fmt::format("`{}` is none of left, right and middle", word);
    }
    const bool counts =
        number && *number >= 1 && *number <= kCountMost && *number == std::floor(*number);
    if (kind == 'c' && !counts) {
        return fmt::format("`{}` is no whole number from 1 to {:.0f}", word, kCountMost);
    }
    return {};
}

constexpr int kFramesOfDrag = 6;

}  // namespace

Result<ViewScript> ViewScript::read(const std::string& path) {
    std::ifstream file(path);
    if (!file) return Error{path + ": cannot be read; check its name and rights"};
    ViewScript script;
    script.path_ = path;
    int number = 0;
    for (std::string line; std::getline(file, line);) {
        ++number;
        Action action{number, words_of(line)};
        if (action.words.empty() || action.words[0][0] == '#') continue;
        const auto known = arguments_of().find(action.words[0]);
        if (known == arguments_of().end()) {
            return Error{fmt::format("{}:{}: no action `{}`; check its spelling", path, number,
                                     action.words[0])};
        }
        const std::string& kinds = known->second;
        if (action.words.size() != kinds.size() + 1) {
            return Error{fmt::format("{}:{}: `{}` must have {} words, {} given", path, number,
                                     action.words[0], kinds.size(), action.words.size() - 1)};
        }
        for (size_t w = 0; w < kinds.size(); ++w) {
            const std::string mistake = mistake_in(action.words[w + 1], kinds[w]);
            if (!mistake.empty()) return Error{fmt::format("{}:{}: {}", path, number, mistake)};
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
        if (!place) {
            return fail(action, "no widget `" + word(1) + "` is shown; open its panel first");
        }
        ImVec2 at{0.5f * (place->low.x + place->high.x), 0.5f * (place->low.y + place->high.y)};
        // Within the bar: its very ends belong to what is beside it.
        if (verb == "slide") {
            at.x =
                place->low.x + std::clamp(number(2), 0.01f, 0.99f) * (place->high.x - place->low.x);
        }
        press(at, 0);
    } else if (verb == "drag") {
        const int button = button_of(word(1));
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
            return fail(action, "no key `" + word(1) + "`; name one as SDL does");
        }
        Frame down, held, up;
        down.key = up.key = word(1);
        down.key_down = true;
        frames.push_back(down);
        if (verb == "hold") {
            held.steps = count_of(word(2));
            frames.emplace_back();
            frames.push_back(held);
        }
        frames.push_back(up);
        frames.emplace_back();
    } else if (verb == "steps") {
        Frame frame;
        frame.steps = count_of(word(1));
        frames.push_back(frame);
        frames.emplace_back();
    } else if (verb == "frames") {
        frames.resize(static_cast<size_t>(count_of(word(1))));
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
