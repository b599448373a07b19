#!/usr/bin/env bash
# Checks that the pages can be read in a hurry: no sentence of more than 40 words. Code, headings and addresses do not count; a
# list item and a table's cell end a sentence as a full stop does. Left out are pages that a command prints, the changelog and
# the longer stories below a decision.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"
most=${1:-40}
pages=(README.md bridge/README.md plugin/README.md demos/src/README.md tests/*/README.md docs/*.md docs/questions/*.md docs/decisions/*.md)
for page in "${pages[@]}"; do
    [[ $page == docs/validation.md ]] && continue # mostly printed
    awk -v most="$most" -v page="$page" '
        function flush(   n, i, parts, words, count) {
            gsub(/\]\([^)]*\)/, "]", text)
            n = split(text, parts, /[.!?][)*"]*[ \t]+/)
            for (i = 1; i <= n; ++i) {
                count = 0
                gsub(/[^A-Za-z0-9_]*[ \t]+[^A-Za-z0-9_]*/, " ", parts[i])
                words = parts[i]
                while (match(words, /[A-Za-z0-9_]+[^ ]*/)) { ++count; words = substr(words, RSTART + RLENGTH) }
                if (count > most) { printf "%s: %d words: %.100s\n", page, count, parts[i]; bad = 1 }
            }
            text = ""
        }
        /^```/ { flush(); in_code = !in_code; next }
        in_code || /^    / && text == "" || /^<!--/ { next }
        /^## The longer story/ { exit }
        /^#/ || /^$/ { flush(); next }
        /^\|/ { flush(); m = split($0, cells, "|"); for (c = 1; c <= m; ++c) { text = cells[c]; flush() }; next }
        /^ *([-*]|[0-9]+\.) / { flush() }
        { text = text " " $0 }
        END { flush(); exit bad }' "$page" || failed=1
done
exit "$failed"
