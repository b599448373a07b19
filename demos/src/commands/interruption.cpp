#include "interruption.h"

#include <csignal>

namespace bsoil::command {
namespace {

volatile std::sig_atomic_t asked = 0;

void ask(int) { asked = 1; }

void set_handler(void (*handler)(int), int flags) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = flags;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

Interruption::Interruption() {
    asked = 0;
    set_handler(ask, static_cast<int>(SA_RESETHAND));
}
Interruption::~Interruption() { set_handler(SIG_DFL, 0); }
bool Interruption::is_asked() const { return asked != 0; }

}  // namespace bsoil::command
