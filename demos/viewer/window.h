/// A window with an OpenGL context and Dear ImGui in it.
#pragma once

#include <SDL.h>

#include <memory>
#include <string>

#include "bsoil/render/image.h"
#include "bsoil/result.h"

namespace bsoil::viewer {

/// How a window is made.
struct WindowDef {
    std::string title;
    int width = 1280, height = 720;
    bool is_resizable = true;
    bool waits_for_screen = true;  ///< swaps with the screen's refresh
};

/// One at a time: SDL and ImGui are global.
class Window {
  public:
    /// The error says what is missing: no display, no OpenGL 3.3.
    static Result<std::unique_ptr<Window>> create(const WindowDef& def);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    /// Size of what is drawn into [pixels].
    int width() const;
    int height() const;
    /// Begins a frame of ImGui. Between begin() and end() panels are laid out.
    void begin();
    /// Ends it: the picture is drawn next, then the panels over it.
    void end();
    /// Draws the panels over what is in the window.
    void draw_panels();
    void swap();
    /// What is in the window before swap().
    render::Image read() const;

  private:
    Window() = default;
    SDL_Window* window_ = nullptr;
    SDL_GLContext context_ = nullptr;
};

}  // namespace bsoil::viewer
