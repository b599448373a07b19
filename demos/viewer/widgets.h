/// ImGui's widgets, with a note of where each was drawn: a script clicks them by name.
#pragma once

#include <imgui.h>

#include <map>
#include <optional>
#include <string>

namespace bsoil::viewer {

class Widgets {
  public:
    /// Forgets where widgets were; before a frame is laid out.
    void begin() { places_.clear(); }

    static void heading(const char* text) {
        ImGui::Spacing();
        ImGui::TextColored({0.93f, 0.60f, 0.16f, 1}, "%s", text);
    }
    bool button(const char* label, ImVec2 size = {0, 0}) {
        return noted(label, ImGui::Button(label, size));
    }
    bool checkbox(const char* label, bool* value) {
        return noted(label, ImGui::Checkbox(label, value));
    }
    bool radio(const char* label, bool active) {
        return noted(label, ImGui::RadioButton(label, active));
    }
    bool slider(const char* label, float* value, float low, float high, const char* format,
                ImGuiSliderFlags flags = 0) {
        const float width = ImGui::CalcItemWidth();  // of the bar, without the label beside it
        const bool changed =
            noted(label, ImGui::SliderFloat(label, value, low, high, format, flags));
        places_[label].high.x = places_[label].low.x + width;
        return changed;
    }
    bool tab(const char* label) { return noted(label, ImGui::BeginTabItem(label)); }
    bool selectable(const char* label, bool selected) {
        return noted(label, ImGui::Selectable(label, selected));
    }
    bool combo(const char* label, const char* shown) {
        return noted(label, ImGui::BeginCombo(label, shown));
    }

    struct Place {
        ImVec2 low, high;
    };
    /// Where a widget was drawn in the last frame; none: it was not.
    std::optional<Place> place(const std::string& label) const {
        const auto found = places_.find(label);
        if (found == places_.end()) return {};
        return found->second;
    }

  private:
    bool noted(const char* label, bool result) {
        places_[label] = {ImGui::GetItemRectMin(), ImGui::GetItemRectMax()};
        return result;
    }
    std::map<std::string, Place> places_;
};

}  // namespace bsoil::viewer
