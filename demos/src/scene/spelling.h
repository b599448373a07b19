/// What a mistyped word was meant to be.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace bsoil::scene {

/// Letters to insert, remove or replace to come from one word to the other (Levenshtein).
inline size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<size_t> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t above = row[j];
            const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            row[j] = std::min({above + 1, row[j - 1] + 1, replaced});
            diagonal = above;
        }
    }
    return row[b.size()];
}

/// Letters that may be wrong in a word that is still a typing error.
inline size_t typing_errors_most(const std::string& word) { return word.size() / 3 + 1; }

/// The word that was probably meant; empty where none is near.
inline std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
    std::string nearest;
    size_t least = typing_errors_most(word) + 1;
    for (const std::string& candidate : known) {
        const size_t distance = edit_distance(word, candidate);
        if (distance >= least) continue;
        least = distance;
        nearest = candidate;
    }
    return nearest;
}

}  // namespace bsoil::scene
