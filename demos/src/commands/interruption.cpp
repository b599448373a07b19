#include "interruption.h"

#include <csignal>

namespace bsoil::command {
namespace {

volatile std::sig_atomic_t asked = 0;

void set_handler(void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

/// Whichever came first, the next of both ends the program.
void ask(int) {
    asked = 1;
    set_handler(SIG_DFL);
}

}  // namespace

Interruption::Interruption() {
    asked = 0;
    set_handler(ask);
}
Interruption::~Interruption() { set_handler(SIG_DFL); }
bool Interruption::is_asked() const { return asked != 0; }

}  // namespace bsoil::command
