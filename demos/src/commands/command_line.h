/// What a command line says that no command knows, and ranges of numbers in plain words.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace bsoil::command {

/// Names the first word that is no command, or no option of the command before it, with what was
/// probably meant. Empty where every word is known.
std::string unknown_word(const CLI::App& app, int argument_count, const char* const* arguments);

/// A command that this build lacks: whatever stands behind it, it prints `why` and ends with
/// kCouldNotRun.
void add_left_out(CLI::App& app, const std::string& name, const std::string& why, int& exit_code);

/// Accepts numbers of at least `least`: "0 is too small, must be 1 or more".
CLI::Validator at_least(double least);

}  // namespace bsoil::command
