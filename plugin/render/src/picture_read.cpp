/// Pictures and what they show, read back from the device.
#include <algorithm>

#include "picture.h"
#include "uniforms.h"

namespace bsoil::render {
namespace {

/// GL counts rows from below.
template <typename T>
void turn_over(std::vector<T>& pixels, int width, int height, size_t parts) {
    const size_t row = parts * static_cast<size_t>(width);
    for (int y = 0; y < height / 2; ++y) {
        T* upper = &pixels[row * static_cast<size_t>(y)];
        std::swap_ranges(upper, upper + row, &pixels[row * static_cast<size_t>(height - 1 - y)]);
    }
}

}  // namespace

Result<Image> Picture::take(const View& view) {
    create_targets(view.width, view.height);
    if (const Status drawn = draw(view, picture_.framebuffer.name()); !drawn) {
        return Error{drawn.error()};
    }
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    Image image{view.width, view.height, {}};
    image.rgba.resize(4 * static_cast<size_t>(view.width) * static_cast<size_t>(view.height));
    glReadPixels(0, 0, view.width, view.height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    turn_over(image.rgba, view.width, view.height, 4);
    return image;
}

Result<Buffers> Picture::take_buffers(const View& view) {
    const Frame f = make_frame(view);
    const GlFramebuffer framebuffer("buffers");
    const GlTexture2D normal_depth("normals and depth"), labels("labels");
    const GlRenderbuffer depth("depth of buffers");
    glBindTexture(GL_TEXTURE_2D, normal_depth.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, view.width, view.height, 0, GL_RGBA, GL_FLOAT,
                 nullptr);
    glBindTexture(GL_TEXTURE_2D, labels.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R32UI, view.width, view.height, 0, GL_RED_INTEGER,
                 GL_UNSIGNED_INT, nullptr);
    glBindRenderbuffer(GL_RENDERBUFFER, depth.name());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, view.width, view.height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, normal_depth.name(),
                           0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, labels.name(), 0);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth.name());
    const GLenum attachments[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(2, attachments);
    const GLfloat nothing[4] = {0, 0, 0, 0}, far = 1;
    const GLuint no_label[4] = {0, 0, 0, 0};
    glViewport(0, 0, view.width, view.height);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glDisable(GL_BLEND);
    glCullFace(GL_BACK);
    glFrontFace(GL_CCW);
    glClearBufferfv(GL_COLOR, 0, nothing);
    glClearBufferuiv(GL_COLOR, 1, no_label);
    glClearBufferfv(GL_DEPTH, 0, &far);
    const Uniforms uniforms(buffers_);
    uniforms.set("clip", f.clip);
    uniforms.set("sight", glm::normalize(glm::vec3(glm::transpose(f.look)[2]) * -1.0f));
    const GLint label = uniforms.at("item_label");
    for (const Placed& placed : f.items) {
        glUniform1ui(label, placed.item ? placed.item->label : 0);
        uniforms.draw_seen(placed, f.cut);
    }
    grain_layer_.fill(view, f, 1);
    if (!grain_layer_.is_empty()) {
        const Uniforms grain_uniforms(grain_buffers_);
        grain_uniforms.set("clip", f.clip);
        grain_uniforms.set("facing", glm::vec3(0));
        grain_uniforms.set("sight", glm::normalize(glm::vec3(glm::transpose(f.look)[2]) * -1.0f));
        glUniform1ui(grain_uniforms.at("item_label"), view.grain_label);
        grain_layer_.draw();
    }
    Buffers out;
    out.width = view.width;
    out.height = view.height;
    const size_t pixel_count = static_cast<size_t>(view.width) * static_cast<size_t>(view.height);
    std::vector<float> both(4 * pixel_count);
    out.labels.resize(pixel_count);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glReadPixels(0, 0, view.width, view.height, GL_RGBA, GL_FLOAT, both.data());
    glReadBuffer(GL_COLOR_ATTACHMENT1);
    glReadPixels(0, 0, view.width, view.height, GL_RED_INTEGER, GL_UNSIGNED_INT, out.labels.data());
    turn_over(both, view.width, view.height, 4);
    turn_over(out.labels, view.width, view.height, 1);
    out.normals.reserve(3 * pixel_count);
    out.depths_m.reserve(pixel_count);
    for (size_t p = 0; p < pixel_count; ++p) {
        out.normals.insert(out.normals.end(), &both[4 * p], &both[4 * p + 3]);
        out.depths_m.push_back(both[4 * p + 3]);
    }
    restore_state(view, 0);
    const GLenum error = glGetError();
    if (error != GL_NO_ERROR) {
        return Error{"OpenGL reports error " + std::to_string(error) + " for buffers of " +
                     std::to_string(view.width) + " x " + std::to_string(view.height) +
                     " pixels; take fewer pixels, or another driver"};
    }
    return out;
}

}  // namespace bsoil::render
