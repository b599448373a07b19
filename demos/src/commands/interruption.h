/// Ctrl-C: a run ends after the step at hand and leaves behind what it has.
#pragma once

namespace bsoil::command {

/// While it lives SIGINT and SIGTERM ask for the end; a second one ends the program at once.
class Interruption {
  public:
    Interruption();
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;
    bool is_asked() const;
};

}  // namespace bsoil::command
