/// Runs fuzz targets over their seeds with any compiler:
/// fuzz_replay TARGET RUNS [FILE or FOLDER...]. Each file as it is, then RUNS times with changes
/// that depend on the file's name and the run's number alone. What ends the program is left in the
/// file fuzz_TARGET_found.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "fuzz_target.h"

namespace fs = std::filesystem;

namespace {

// For the handler, which may use no more than plain memory and system calls.
const uint8_t* input_data = nullptr;
size_t input_size = 0;
char found_path[256] = "";
char handler_stack[65536];

void keep_input(int number) {
    const int file = open(found_path, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (file >= 0 && write(file, input_data, input_size) >= 0) close(file);
    std::signal(number, SIG_DFL);
    std::raise(number);
}

void keep_input_of_crashes(const char* target) {
    std::snprintf(found_path, sizeof found_path, "fuzz_%s_found", target);
    stack_t stack{};  // a recursion without end leaves no room on its own
    stack.ss_sp = handler_stack;
    stack.ss_size = sizeof handler_stack;
    sigaltstack(&stack, nullptr);
    struct sigaction action {};
    action.sa_handler = keep_input;
    action.sa_flags = SA_ONSTACK;
    for (const int number : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGTERM}) {
        sigaction(number, &action, nullptr);
    }
}

void run_on(const bsoil::fuzz::Target& target, const std::vector<uint8_t>& input) {
    input_data = input.data();
    input_size = input.size();
    target.run(input);
}

}  // namespace

int main(int argument_count, char** arguments) {
    using namespace bsoil::fuzz;
    const Target* target = nullptr;
    for (const Target& one : targets()) {
        if (argument_count > 2 && std::strcmp(one.name, arguments[1]) == 0) target = &one;
    }
    if (!target) {
        std::fprintf(stderr, "usage: fuzz_replay TARGET RUNS [FILE or FOLDER...]\n");
        return 2;
    }
    const int run_count = std::atoi(arguments[2]);
    std::vector<fs::path> files;
    for (int i = 3; i < argument_count; ++i) {
        if (!fs::is_directory(arguments[i])) {
            files.emplace_back(arguments[i]);
            continue;
        }
        for (const auto& entry : fs::directory_iterator(arguments[i])) {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    keep_input_of_crashes(target->name);
    run_on(*target, {});
    for (const fs::path& path : files) {
        std::printf("%s\n", path.filename().c_str());
        std::fflush(stdout);
        std::ifstream file(path, std::ios::binary);
        const std::vector<uint8_t> seed{std::istreambuf_iterator<char>(file), {}};
        run_on(*target, seed);
        const std::string name = path.filename().string();
        std::seed_seq name_seed(name.begin(), name.end());
        std::mt19937 random(name_seed);
        for (int run = 0; run < run_count; ++run) {
            std::vector<uint8_t> changed = seed;
            std::vector<uint8_t> changes(64);
            for (uint8_t& byte : changes) byte = static_cast<uint8_t>(random());
            Choices choices(changes);
            edit(changed, choices);
            run_on(*target, changed);
        }
    }
    std::printf("%s: %zu seeds, %d changes to each\n", target->name, files.size(), run_count);
    return 0;
}
