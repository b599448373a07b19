#include "picture.h"

namespace bsoil::render {

void PassTimer::create() {
    for (auto& picture : queries_) {
        for (GlQuery& query : picture) query = GlQuery("pass time");
    }
}

void PassTimer::mark(Mark at) {
    if (at == kBegin) {
        is_open_ = !is_out_[next_];  // the device is kInFlight pictures behind: leave this one out
    }
    if (!is_open_) return;
    glQueryCounter(queries_[next_][at].name(), GL_TIMESTAMP);
    if (at + 1 < kMarkCount) return;
    is_out_[next_] = true;
    next_ = (next_ + 1) % kInFlight;
    is_open_ = false;
}

void PassTimer::poll() {
    while (is_out_[oldest_]) {
        GLint ready = GL_FALSE;
        glGetQueryObjectiv(queries_[oldest_][kMarkCount - 1].name(), GL_QUERY_RESULT_AVAILABLE,
                           &ready);
        if (!ready) return;
        GLuint64 ns[kMarkCount] = {};
        for (int m = 0; m < kMarkCount; ++m) {
            glGetQueryObjectui64v(queries_[oldest_][m].name(), GL_QUERY_RESULT, &ns[m]);
        }
        const auto between_ms = [&](Mark from, Mark to) {
            return ns[to] > ns[from] ? static_cast<double>(ns[to] - ns[from]) * 1e-6 : 0.0;
        };
        times_ = {between_ms(kBegin, kShadow), between_ms(kShadow, kSurface),
                  between_ms(kSurface, kOcclusion), between_ms(kOcclusion, kLight),
                  between_ms(kLight, kFinish)};
        is_out_[oldest_] = false;
        oldest_ = (oldest_ + 1) % kInFlight;
    }
}

}  // namespace bsoil::render
