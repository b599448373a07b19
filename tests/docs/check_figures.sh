#!/usr/bin/env bash
# Checks that pages say what wrote their figures: check_figures.sh BUILD_FOLDER. A table with six figures or more in docs/*.md
# or docs/questions has one of these lines right above it (decisions are dated by their nature and go without):
#
#   <!-- figures: printed by PROGRAM ARGUMENTS... -->   a program of the build prints each row of the table as it stands here:
#                                                       run here, and compared
#   <!-- figures: PROGRAM ARGUMENTS... -->              that takes minutes: not run; the program knows the word after its name
#   <!-- figures: Suite.test -->                        a test that prints them, or holds them; Suite.* for some of a suite
#   <!-- figures: from FILE -->                         a file of the tree that they are in
#   <!-- figures: YYYY-MM-DD, HOW -->                   a measurement made once, and how to make it again
#
# Between `<!-- bsoil validate: ... -->` and `<!-- end -->` the command replaces what stands there; experiment.validate holds it.
set -uo pipefail
build=$(cd "${1:?usage: check_figures.sh BUILD_FOLDER}" && pwd) || exit 1
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1
failed=0
fail() {
    printf '%s\n' "$*"
    failed=1
}

# Prints "FILE:LINE<tab>MARK" for every table of figures, without a mark where there is none.
list_tables() {
    awk '
        function flush() {
            if (rows > 2 && figures >= 6 && !replaced) printf "%s:%d\t%s\n", FILENAME, first, mark
            rows = 0
        }
        FNR == 1 { inside = 0; rows = 0; last = "" }
        /^<!-- bsoil validate: / { inside = 1 }
        /^<!-- end -->/ { inside = 0 }
        /^\|/ {
            if (rows == 0) {
                first = FNR; figures = 0; replaced = inside
                mark = last ~ /^<!-- figures: .* -->$/ ? substr(last, 15, length(last) - 18) : ""
            }
            if (++rows > 2) {
                count = split($0, cells, /\|/)
                for (i = 3; i < count; ++i)
                    if (cells[i] ~ /^ *[-+*]*[0-9][-0-9., %x]*[*a-zA-Z\/%]* *$/) ++figures
            }
            next
        }
        { flush() }
        NF { last = $0 }
    ' "$1"
}

program_of() { find "$build/demos" "$build/tests" -maxdepth 2 -type f -name "$1" -perm -u+x | head -n 1; }

# compare FILE LINE WORD...: the rows of the table at the line among what the program prints.
compare() {
    local file=$1 line=$2 program output row
    shift 2
    program=$(program_of "$1")
    [[ -n $program ]] || { fail "$file:$line: $1 is not in the build"; return; }
    output=$("$program" "${@:2}" 2>&1)
    if grep -q '^\[  SKIPPED \]' <<<"$output"; then
        printf '%s\n' "$file:$line: '$*' skips what prints them"
        return
    fi
    while IFS= read -r row; do
        grep -qxF -- "$row" <<<"$output" || fail "$file: '$*' does not print
    $row"
    done < <(awk -v first="$line" 'FNR > first + 1 { if (!/^\|/) exit; print }' "$file")
}

count=0
while IFS=$'\t' read -r place mark; do
    ((++count))
    read -ra words <<<"$mark"
    case $mark in
        '') fail "$place: a table of figures without <!-- figures: ... --> above it" ;;
        'printed by '*) compare "${place%:*}" "${place##*:}" "${words[@]:2}" ;;
        'from '*) [[ -f ${words[1]} ]] || fail "$place: no file ${words[1]}" ;;
        20[0-9][0-9]-[0-9][0-9]-[0-9][0-9],\ *) ;;
        bsoil\ *) "$(program_of bsoil)" "${words[1]}" --help >/dev/null 2>&1 || fail "$place: no command 'bsoil ${words[1]}'" ;;
        *.*) grep -rqE "TEST(_F|_P)?\(${words[0]%%.*}, ${words[0]#*.}" tests || fail "$place: no test ${words[0]}" ;;
        *) fail "$place: what is '$mark'?" ;;
    esac
done < <(for page in docs/*.md docs/questions/*.md; do list_tables "$page"; done)
((count)) || fail "no table of figures found"
exit "$failed"
