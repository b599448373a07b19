#!/usr/bin/env bash
# Checks the equation index of plugin/README.md: every equation of the thesis that is computed has a row, its number stands in the named file in a comment
# that speaks of the thesis ("thesis (34)", "thesis (1) to (4)"; further numbers in the same comment count), and the
# named function is in that file.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"

# Numbers in the comments of a file that speak of the thesis; a comment is a run of comment lines.
numbers_in() {
    awk '
        function flush(   at, text, from, to, i) {
            if (tolower(comment) ~ /thesis/) {
                text = comment
                while (match(text, /\([0-9]+\)(( to |-)\([0-9]+\))?/)) {
                    at = substr(text, RSTART, RLENGTH)
                    text = substr(text, RSTART + RLENGTH)
                    gsub(/[^0-9]+/, " ", at)
                    split(at, ends, " ")
                    from = ends[1]; to = ends[2] == "" ? from : ends[2]
                    for (i = from; i <= to; ++i) print i
                }
            }
            comment = ""
        }
        {
            start = index($0, "//")
            if (start == 0) { flush(); next }
            if ($0 !~ /^ *\/\//) flush()
            comment = comment " " substr($0, start + 2)
        }
        END { flush() }' "$1"
}

# All that is computed: (12) is the general form of (16), and from (36) on they are fits to timings.
for number in {1..11} {13..35}; do
    row=$(grep -E "^\| \($number\) \|" plugin/README.md)
    file=$(sed -nE 's/.*\| `([^`]+)`: `[^`]+` \|$/\1/p' <<<"$row")
    function=$(sed -nE 's/.*\| `[^`]+`: `([^`]+)` \|$/\1/p' <<<"$row")
    if [[ -z $file || -z $function ]]; then
        fail "($number): no row in the equation index of plugin/README.md"
    elif [[ ! -f $file ]]; then
        fail "($number): $file is not there"
    else
        grep -qE "\b$function\(" "$file" || fail "($number): no function $function in $file"
        numbers_in "$file" | grep -qx "$number" || fail "($number): no comment 'thesis ($number)' in $file"
    fi
done
exit "$failed"
