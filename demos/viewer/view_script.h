/// A script in the place of a person: moves the pointer, presses buttons and keys, takes pictures
/// of the window. A line is one action:
///
///     steps N                     makes N steps and waits for them
///     click NAME                  the widget of that label
///     slide NAME FRACTION         a slider, to a fraction of its width
///     drag BUTTON X0 Y0 X1 Y1     left, middle or right; fractions of the window
///     wheel N                     over the middle of the window
///     key NAME                    presses and lets go; names as SDL has them ("Space", "F5")
///     hold NAME N                 keeps a key down for N steps
///     frames N                    lets N frames pass
///     screenshot FILE             a PNG of the whole window
///
/// Empty lines and lines that begin with # are left out.
#pragma once

#include <SDL.h>

#include <functional>
#include <string>
#include <vector>

#include "bsoil/result.h"
#include "simulation.h"
#include "widgets.h"
#include "window.h"

namespace bsoil::viewer {

class ViewScript {
  public:
    /// The error names file, line and what is wrong.
    static Result<ViewScript> read(const std::string& path);

    /// What this frame's input is: called between Window::begin() and ImGui::NewFrame(). False once
    /// the script is at its end.
    bool begin_frame(Simulation& simulation, const Widgets& widgets, ImVec2 window);
    /// After the frame is drawn and before it is shown: takes a picture if one is due.
    void end_frame(const Window& window);
    /// What went wrong; empty: nothing.
    const std::string& error() const { return error_; }

  private:
    struct Action {
        int line = 0;
        std::vector<std::string> words;
    };
    /// The pointer and the keys of one frame.
    struct Frame {
        ImVec2 pointer{-1, -1};
        int button = -1;  ///< held down: 0 left, 1 right, 2 middle
        float wheel = 0;
        std::string key;  ///< goes down or up
        bool key_down = false;
        int steps = 0;
        std::string screenshot;
    };
    void expand(const Action& action, const Widgets& widgets, ImVec2 window);
    void fail(const Action& action, const std::string& why);

    std::string path_;
    std::vector<Action> actions_;
    size_t next_ = 0;
    std::vector<Frame> frames_;  ///< of the action at hand, the next one last
    std::string screenshot_;
    ImVec2 pointer_{-1, -1};
    std::string error_;
};

}  // namespace bsoil::viewer
