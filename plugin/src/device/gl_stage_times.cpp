#include "device/gl_stage_times.h"

#include <algorithm>

namespace bsoil::device {

// Stamps are made in order: when the last one is there, all are.
bool GlStageTimes::is_finished(const Session& session) {
    GLuint is_available = GL_FALSE;
    glGetQueryObjectuiv(session.stamps[session.works.size() - 1].name(), GL_QUERY_RESULT_AVAILABLE,
                        &is_available);
    return is_available == GL_TRUE;
}

void GlStageTimes::read(const Session& session, std::span<double> stage_ms,
                        std::span<double> kernel_ms) {
    constexpr double kMsPerNs = 1e-6;
    std::ranges::fill(stage_ms, 0);
    GLuint64 before_ns = 0;
    for (size_t i = 0; i < session.works.size(); ++i) {
        GLuint64 now_ns = 0;
        glGetQueryObjectui64v(session.stamps[i].name(), GL_QUERY_RESULT, &now_ns);
        if (i > 0 && now_ns > before_ns) {
            const auto [stage, kernel] = session.works[i - 1];
            const double ms = static_cast<double>(now_ns - before_ns) * kMsPerNs;
            if (stage != kNone) stage_ms[static_cast<size_t>(stage)] += ms;
            if (kernel != kNone) kernel_ms[static_cast<size_t>(kernel)] += ms;
        }
        before_ns = now_ns;
    }
}

void GlStageTimes::begin(std::span<double> stage_ms, std::span<double> kernel_ms) {
    // From the oldest on, so that the newest one stays.
    for (size_t i = 0; i < kSessions; ++i) {
        Session& session = sessions_[(next_ + i) % kSessions];
        if (session.is_pending && is_finished(session)) {
            read(session, stage_ms, kernel_ms);
            session.is_pending = false;
        }
    }
    current_ = sessions_[next_].is_pending ? nullptr : &sessions_[next_];
    stage_ = kNone;
    if (current_) current_->works.clear();
}

void GlStageTimes::stamp(Work work) {
    stage_ = work.stage;
    if (!current_) return;
    current_->works.push_back(work);
    if (current_->stamps.size() < current_->works.size()) {
        GLuint name = 0;
        glCreateQueries(GL_TIMESTAMP, 1, &name);
        current_->stamps.emplace_back(name);
    }
    glQueryCounter(current_->stamps[current_->works.size() - 1].name(), GL_TIMESTAMP);
}

void GlStageTimes::end() {
    if (current_ && !current_->works.empty()) {
        stamp({});
        current_->is_pending = true;
        next_ = (next_ + 1) % kSessions;
    }
    current_ = nullptr;
}

}  // namespace bsoil::device
