/// Whether a refusal also says what to do about it.
#pragma once

#include <algorithm>
#include <iterator>
#include <regex>
#include <string>

namespace bsoil {

// tests/docs/check_cures.sh reads both lists and asks the same of every text in the sources.

/// What says what may be.
inline constexpr const char* kRangeWords[] = {
    "must",         "needs",           "at most",      "at least",
    "expected",     "one of",          "allowed",      "may",
    "these are",    "the columns are", "out of range", "usage:",
    "did you mean", "the keys are",    "the key is",   "have to",
    "there are",    "is written once"};

/// What a text tells to do, at the beginning of a clause.
inline constexpr const char* kOrderWords[] = {
    "add",      "ask",    "attach",  "build",  "call",    "change", "check", "choose",    "close",
    "convert",  "create", "cut",     "draw",   "enlarge", "export", "fill",  "give",      "go on",
    "hand",     "ignore", "install", "leave",  "let",     "link",   "load",  "look",      "lower",
    "make",     "move",   "name",    "put",    "say",     "scale",  "open",  "normalize", "pour",
    "raise",    "remove", "release", "rename", "report",  "run",    "save",  "set",       "show",
    "simplify", "take",   "wait",    "write"};

/// A range, or an order behind a semicolon, colon, comma, full stop or dash.
inline bool says_what_to_do(const std::string& reason) {
    static const std::regex orders = [] {
        std::string words;
        for (const char* word : kOrderWords) {
            words += std::string(words.empty() ? "" : "|") + word;
        }
        return std::regex("[;:,.] (or |please |then )?(" + words + ")\\b");
    }();
    return std::any_of(std::begin(kRangeWords), std::end(kRangeWords),
                       [&](const char* word) { return reason.find(word) != std::string::npos; }) ||
           std::regex_search(reason, orders);
}

}  // namespace bsoil
