#!/usr/bin/env bash
# Checks that the pages can be read in a hurry: no sentence of more than 40 words. Code, headings and addresses do not count; a
# list item and a table's cell end a sentence as a full stop does. Left out are what a command prints, the changelog and
# the longer stories below a decision. In comments of headers a colon and a semicolon end a sentence too.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"
most=${1:-40}
pages=(README.md bridge/README.md plugin/README.md demos/src/README.md tests/*/README.md docs/*.md docs/questions/*.md docs/decisions/*.md docs/records/*.md)
for page in "${pages[@]}"; do
    awk -v most="$most" -v page="$page" '
        function flush(   n, i, parts, words, count) {
            gsub(/\]\([^)]*\)/, "]", text)
            gsub(/<!--[^>]*-->/, "", text)
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
        /^<!-- bsoil [a-z]+: / { printed = 1 } # by a command
        /^<!-- end -->/ { printed = 0 }
        printed { next }
        in_code || /^    / && text == "" || /^<!--[^>]*-->$/ { next }
        /^#/ || /^$/ { flush(); next }
        /^\|/ { flush(); m = split($0, cells, "|"); for (c = 1; c <= m; ++c) { text = cells[c]; flush() }; next }
        /^ *([-*]|[0-9]+\.) / { flush() }
        { text = text " " $0 }
        END { flush(); exit bad }' "$page" || failed=1
done

# The same of what the headers say in `///`. A line that is indented more than the text is a formula.
while IFS= read -r found; do
    fail "$found"
done < <(git ls-files -z '*.h' | xargs -0 awk -v most="$most" '
    function flush(   n, i, parts, words, count) {
        gsub(/`[^`]*`/, "x", text)
        n = split(text, parts, /[.!?:;][)*"]*[ \t]+/)
        for (i = 1; i <= n; ++i) {
            count = 0
            words = parts[i]
            while (match(words, /[A-Za-z0-9_]+[^ ]*/)) { ++count; words = substr(words, RSTART + RLENGTH) }
            if (count > most) printf "%s:%d: %d words: %.100s\n", file, from, count, parts[i]
        }
        text = ""
    }
    FNR == 1 { flush() }
    /^[ \t]*\/\/\/( [^ ]|$)/ {
        if (text == "") { from = FNR; file = FILENAME }
        line = $0
        sub(/^[ \t]*\/\/\/ ?/, "", line)
        if (line == "" || line ~ /^- /) flush()
        text = text " " line
        next
    }
    { flush() }
    END { flush() }')
exit "$failed"
