/// Times of stages by the GPU's own clock, read without waiting for it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "device/gl_objects.h"

namespace bsoil::device {

/// Puts time stamps between the commands of a session and looks at them when later sessions begin.
/// A context must be current in every call but the destructor, where one must be for the objects.
class GlStageTimes {
  public:
    /// Reads the newest session whose stamps have all been made, if there is a new one, into
    /// `stage_ms`; begins the next one. While the stamps of kSessions sessions are under way the
    /// next one goes untimed.
    void begin(std::span<double> stage_ms);
    /// Commands from here on belong to a stage.
    void mark(int stage);
    void end();

  private:
    static constexpr size_t kSessions = 3;
    static constexpr int kNoStage = -1;
    struct Session {
        std::vector<GlQuery> stamps;
        std::vector<int> stages;  ///< that begins with a stamp
        bool is_pending = false;
    };
    static bool is_finished(const Session& session);
    static void read(const Session& session, std::span<double> stage_ms);

    std::array<Session, kSessions> sessions_;
    size_t next_ = 0;             ///< of sessions_, the one to take after this
    Session* current_ = nullptr;  ///< null between sessions and in an untimed one
};

}  // namespace bsoil::device
