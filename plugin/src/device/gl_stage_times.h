/// Times of stages and kernels by the GPU's own clock, read without waiting for it.
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
    /// Reads the sessions whose stamps have all been made: the newest one into `stage_ms`, and all
    /// of them added to `kernel_ms`. Then begins the next one. While the stamps of kSessions
    /// sessions are under way the next one goes untimed.
    void begin(std::span<double> stage_ms, std::span<double> kernel_ms);
    /// Commands from here on belong to a stage and to no kernel.
    void mark(int stage) { stamp({stage, kNone}); }
    /// Commands from here on belong to a kernel of the present stage, up to end_kernel().
    void begin_kernel(int kernel) { stamp({stage_, kernel}); }
    void end_kernel() { stamp({stage_, kNone}); }
    void end();

  private:
    static constexpr size_t kSessions = 3;
    static constexpr int kNone = -1;
    /// What begins with a stamp.
    struct Work {
        int stage = kNone, kernel = kNone;
    };
    struct Session {
        std::vector<GlQuery> stamps;
        std::vector<Work> works;  ///< of each stamp
        bool is_pending = false;
    };
    static bool is_finished(const Session& session);
    static void read(const Session& session, std::span<double> stage_ms,
                     std::span<double> kernel_ms);
    void stamp(Work work);

    std::array<Session, kSessions> sessions_;
    size_t next_ = 0;  ///< of sessions_, the one to take after this
    int stage_ = kNone;
    Session* current_ = nullptr;  ///< null between sessions and in an untimed one
};

}  // namespace bsoil::device
