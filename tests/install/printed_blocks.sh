#!/usr/bin/env bash
# What a page says that programs print:
#   printed_blocks.sh PAGE compare|update
# Runs, here, the command of each `<!-- printed by COMMAND -->` of the page and compares what it prints with the ```text block
# below it, or writes it there. Words have to be equal, and numbers within a tenth and two units of their last digit: the
# figures are those of one machine, and another compiler's Bullet parts from it in the last digits first.
# Exit codes: 0 equal or written, 1 different.
set -uo pipefail
export LC_ALL=C

page=$1 mode=$2
result=0
marked=()
while IFS= read -r command; do marked+=("$command"); done < <(sed -nE 's/^<!-- printed by (.*) -->$/\1/p' "$page")
blocks=$(grep -c '^```text' "$page")
if ((${#marked[@]} != blocks)); then
    printf '%s has %d text blocks, and %d commands that print one\n' "$page" "$blocks" "${#marked[@]}"
    exit 1
fi

for ((number = 1; number <= blocks; ++number)); do
    sh -c "${marked[number - 1]}" >printed 2>&1
    awk -v wanted="$number" '/^```text/ { inside = ++count == wanted; next } /^```/ { inside = 0 } inside' "$page" >stands
    if [[ $mode == update ]]; then
        awk -v wanted="$number" '
            /^```text/ { print; inside = ++count == wanted; while (inside && (getline line <"printed") > 0) print line; next }
            /^```/ { inside = 0 }
            !inside' "$page" >page.new && cat page.new >"$page"
        continue
    fi
    awk '
        function is_number(word) { return word ~ /^[-+]?[0-9]+(\.[0-9]+)?$/ }
        function last_digit(word) { return 10 ^ -(index(word, ".") ? length(word) - index(word, ".") : 0) }
        function size(x) { return x < 0 ? -x : x }
        function differs(a, b) {
            if (is_number(a) && is_number(b)) return size(a - b) > 0.1 * size(a) + 2 * last_digit(a)
            return a != b
        }
        { n = split($0, words, /[ ,]+/); for (i = 1; i <= n; ++i) if (words[i] != "") text[FILENAME, ++length_of[FILENAME]] = words[i] }
        END {
            if (length_of["stands"] != length_of["printed"]) bad = "another number of words"
            for (i = 1; i <= length_of["stands"] && !bad; ++i)
                if (differs(text["stands", i], text["printed", i])) bad = text["stands", i] " is " text["printed", i]
            if (bad) { print bad; exit 1 }
        }' stands printed >why && continue
    printf '%s: what `%s` prints: %s\n--- the page\n%s\n--- printed\n%s\n' "$page" "${marked[number - 1]}" "$(cat why)" "$(cat stands)" "$(cat printed)"
    result=1
done
exit "$result"
