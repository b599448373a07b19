#include "command_line.h"

#include <fmt/format.h>

#include <cstdlib>
#include <vector>

#include "commands.h"
#include "scene/spelling.h"

namespace bsoil::command {
namespace {

std::string meant_text(const std::string& word, const std::vector<std::string>& known,
                       const std::string& help) {
    const std::string meant = scene::nearest_word(word, known);
    return meant.empty() ? "; see " + help : "; did you mean `" + meant + "`?";
}

}  // namespace

int could_not(const std::string& why) {
    fmt::print(stderr, "{}\n", why);
    return kCouldNotRun;
}

std::string unknown_word(const CLI::App& app, int argument_count, const char* const* arguments) {
    const CLI::App* command = nullptr;
    for (int i = 1; i < argument_count; ++i) {
        const std::string word = arguments[i];
        if (word == "--") return {};  // what follows is no option
        if (!word.starts_with("--")) {
            if (command || word.starts_with("-")) continue;
            std::vector<std::string> names;
            for (const CLI::App* known : app.get_subcommands({})) {
                names.push_back(known->get_name());
                if (known->get_name() == word) command = known;
            }
            if (!command) {
                return fmt::format("unknown command `{}`{}", word,
                                   meant_text(word, names, "bsoil --help"));
            }
            continue;
        }
        const std::string name = word.substr(2, word.find('=') - 2);
        const CLI::App& owner = command ? *command : app;
        if (owner.get_allow_extras()) return {};
        bool is_known = false;
        std::vector<std::string> names;
        for (const CLI::Option* option : owner.get_options()) {
            is_known |= option->check_lname(name);
            for (const std::string& known : option->get_lnames()) names.push_back("--" + known);
        }
        if (is_known) continue;
        const std::string whose = command ? "bsoil " + command->get_name() : "bsoil";
        return fmt::format("{}: unknown option `--{}`{}", whose, name,
                           meant_text("--" + name, names, whose + " --help"));
    }
    return {};
}

void add_left_out(CLI::App& app, const std::string& name, const std::string& why, int& exit_code) {
    CLI::App* command = app.add_subcommand(name, why);
    command->allow_extras();
    command->callback([why, &exit_code] { exit_code = could_not(why); });
}

CLI::Validator at_least(double least) {
    return CLI::Validator(
        [least](std::string& text) {
            char* end = nullptr;
            const double number = std::strtod(text.c_str(), &end);
            if (text.empty() || *end != '\0') return fmt::format("`{}` is no number", text);
            if (!(number >= least)) {
                return fmt::format("{} is too small, must be {:g} or more", text, least);
            }
            return std::string();
        },
        fmt::format("{:g} or more", least));
}

}  // namespace bsoil::command
