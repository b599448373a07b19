#include "window.h"

#include <backends/imgui_impl_opengl3.h>
#include <backends/imgui_impl_sdl.h>
#include <epoxy/gl.h>
#include <imgui.h>

#include <algorithm>
#include <filesystem>

namespace bsoil::viewer {
namespace {

constexpr char kFont[] = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
constexpr float kFontPixels = 14;

ImVec4 grey(float level, float alpha = 1) { return {level, level + 0.01f, level + 0.02f, alpha}; }

/// A quiet, dark look with one accent.
void set_style() {
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = 6;
    style.FrameRounding = 4;
    style.GrabRounding = 4;
    style.TabRounding = 4;
    style.WindowBorderSize = 0;
    style.FramePadding = {8, 4};
    style.ItemSpacing = {8, 6};
    style.WindowPadding = {12, 10};
    style.ScrollbarSize = 10;
    const ImVec4 accent{0.93f, 0.60f, 0.16f, 1}, dim{0.93f, 0.60f, 0.16f, 0.45f};
    ImVec4* c = style.Colors;
    c[ImGuiCol_WindowBg] = grey(0.09f, 0.90f);
    c[ImGuiCol_ChildBg] = grey(0.09f, 0);
    c[ImGuiCol_FrameBg] = grey(0.18f);
    c[ImGuiCol_FrameBgHovered] = grey(0.24f);
    c[ImGuiCol_FrameBgActive] = grey(0.28f);
    c[ImGuiCol_Button] = grey(0.22f);
    c[ImGuiCol_ButtonHovered] = dim;
    c[ImGuiCol_ButtonActive] = accent;
    c[ImGuiCol_SliderGrab] = accent;
    c[ImGuiCol_SliderGrabActive] = accent;
    c[ImGuiCol_CheckMark] = accent;
    c[ImGuiCol_Header] = grey(0.24f);
    c[ImGuiCol_HeaderHovered] = dim;
    c[ImGuiCol_HeaderActive] = accent;
    c[ImGuiCol_Tab] = grey(0.15f);
    c[ImGuiCol_TabHovered] = dim;
    c[ImGuiCol_TabActive] = ImVec4{0.55f, 0.36f, 0.11f, 1};
    c[ImGuiCol_PlotLines] = accent;
    c[ImGuiCol_Separator] = grey(0.25f);
    c[ImGuiCol_Text] = grey(0.90f);
    c[ImGuiCol_TextDisabled] = grey(0.55f);
}

}  // namespace

Result<std::unique_ptr<Window>> Window::create(const WindowDef& def) {
    if (SDL_Init(SDL_INIT_VIDEO | SDL_INIT_GAMECONTROLLER) != 0) {
        return Error{std::string("a window needs a display: ") + SDL_GetError()};
    }
    std::unique_ptr<Window> made(new Window);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
    SDL_GL_SetAttribute(SDL_GL_RED_SIZE, 8);
    SDL_GL_SetAttribute(SDL_GL_DOUBLEBUFFER, 1);
    Uint32 flags = SDL_WINDOW_OPENGL;
    if (def.is_resizable) flags |= SDL_WINDOW_RESIZABLE;
    constexpr int kVersions[][2] = {{4, 5}, {3, 3}};
    for (const auto& [major, minor] : kVersions) {
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, major);
        SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, minor);
        if (!made->window_) {
            made->window_ = SDL_CreateWindow(def.title.c_str(), SDL_WINDOWPOS_CENTERED,
                                             SDL_WINDOWPOS_CENTERED, def.width, def.height, flags);
        }
        if (made->window_) made->context_ = SDL_GL_CreateContext(made->window_);
        if (made->context_) break;
    }
    if (!made->context_) return Error{std::string("a window needs OpenGL 3.3: ") + SDL_GetError()};
    SDL_GL_SetSwapInterval(def.waits_for_screen ? 1 : 0);
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // no file of its own is left in the working folder
    if (std::filesystem::exists(kFont)) {
        ImGui::GetIO().Fonts->AddFontFromFileTTF(kFont, kFontPixels);
    }
    set_style();
    ImGui_ImplSDL2_InitForOpenGL(made->window_, made->context_);
    ImGui_ImplOpenGL3_Init("#version 330 core");
    return made;
}

Window::~Window() {
    if (context_) {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplSDL2_Shutdown();
        ImGui::DestroyContext();
        SDL_GL_DeleteContext(context_);
    }
    if (window_) SDL_DestroyWindow(window_);
    SDL_Quit();
}

int Window::width() const {
    int width = 0, height = 0;
    SDL_GL_GetDrawableSize(window_, &width, &height);
    return std::max(1, width);
}

int Window::height() const {
    int width = 0, height = 0;
    SDL_GL_GetDrawableSize(window_, &width, &height);
    return std::max(1, height);
}

void Window::begin() {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplSDL2_NewFrame();
}

void Window::end() { ImGui::Render(); }

void Window::draw_panels() {
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, width(), height());
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Window::swap() { SDL_GL_SwapWindow(window_); }

render::Image Window::read() const {
    render::Image image{width(), height(), {}};
    const size_t row = 4 * static_cast<size_t>(image.width);
    image.rgba.resize(row * static_cast<size_t>(image.height));
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, image.width, image.height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    for (int y = 0; y < image.height / 2; ++y) {
        std::swap_ranges(image.pixel(0, y), image.pixel(0, y) + row,
                         image.pixel(0, image.height - 1 - y));
    }
    for (size_t p = 3; p < image.rgba.size(); p += 4) image.rgba[p] = 255;
    return image;
}

}  // namespace bsoil::viewer
