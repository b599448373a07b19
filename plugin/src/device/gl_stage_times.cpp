#include "device/gl_stage_times.h"

#include <algorithm>

namespace bsoil::device {

// Stamps are made in order: when the last one is there, all are.
bool GlStageTimes::is_finished(const Session& session) {
    GLuint is_available = GL_FALSE;
    glGetQueryObjectuiv(session.stamps[session.stages.size() - 1].name(), GL_QUERY_RESULT_AVAILABLE,
                        &is_available);
    return is_available == GL_TRUE;
}

void GlStageTimes::read(const Session& session, std::span<double> stage_ms) {
    constexpr double kMsPerNs = 1e-6;
    std::ranges::fill(stage_ms, 0);
    GLuint64 before_ns = 0;
    for (size_t i = 0; i < session.stages.size(); ++i) {
        GLuint64 now_ns = 0;
        glGetQueryObjectui64v(session.stamps[i].name(), GL_QUERY_RESULT, &now_ns);
        if (i > 0 && session.stages[i - 1] != kNoStage && now_ns > before_ns) {
            stage_ms[static_cast<size_t>(session.stages[i - 1])] +=
                static_cast<double>(now_ns - before_ns) * kMsPerNs;
        }
        before_ns = now_ns;
    }
}

void GlStageTimes::begin(std::span<double> stage_ms) {
    // From the oldest on, so that the newest one stays.
    for (size_t i = 0; i < kSessions; ++i) {
        Session& session = sessions_[(next_ + i) % kSessions];
        if (session.is_pending && is_finished(session)) {
            read(session, stage_ms);
            session.is_pending = false;
        }
    }
    current_ = sessions_[next_].is_pending ? nullptr : &sessions_[next_];
    if (current_) {
        current_->stages.clear();
    }
}

void GlStageTimes::mark(int stage) {
    if (!current_) {
        return;
    }
    current_->stages.push_back(stage);
    if (current_->stamps.size() < current_->stages.size()) {
        GLuint name = 0;
        glCreateQueries(GL_TIMESTAMP, 1, &name);
        current_->stamps.emplace_back(name);
    }
    glQueryCounter(current_->stamps[current_->stages.size() - 1].name(), GL_TIMESTAMP);
}

void GlStageTimes::end() {
    if (current_ && !current_->stages.empty()) {
        mark(kNoStage);
        current_->is_pending = true;
        next_ = (next_ + 1) % kSessions;
    }
    current_ = nullptr;
}

}  // namespace bsoil::device
