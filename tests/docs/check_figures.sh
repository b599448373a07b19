#!/usr/bin/env bash
# Checks that pages say what wrote their figures: check_figures.sh BUILD_FOLDER [--slow]. One of these lines stands right above a table
# with six figures or more, on any page, and above what a page of docs/decisions has measured (there for the table after it too):
#
#   <!-- figures: printed by PROGRAM ARGUMENTS... -->   a program of the build prints each row of the table as it stands here:
#                                                       run here, and compared
#   <!-- figures: printed in minutes by PROGRAM... -->  the same with --slow only
#   <!-- figures: held by Suite.test: 0.03 1e-3 -->     the bounds are numbers in the text of that test
#   <!-- figures: from FILE... -->                      each number with a unit or a place behind the point is in one of these files
#   <!-- figures: counted by Suite.test -->             a test reads the page and compares
#   <!-- figures: published, WHERE -->                  somebody else's
#
# A record is not compared: it says what was measured on a day. It stands in docs/decisions or docs/records alone:
#
#   <!-- figures: YYYY-MM-DD, HOW -->                   how to make it again: a command of bsoil or a test, if it is one, is there
#   <!-- figures: YYYY-MM-DD -->                        how, the text beside it says
#
# Sentences of the READMEs and of docs/ that name per cent, milliseconds, bytes or steps a second stand in a section with such a line.
# A section's line holds for all that follows it there, but what is printed for its table alone. A figure within <!-- figure: ... --> and <!-- / --> is a cell of a table.
#
# Between `<!-- bsoil COMMAND: NAME -->` and `<!-- end -->` that command replaces what stands there; docs.validation and the
# experiments' tests compare it. Pages that a command prints as a whole are compared by tests of their own.
#
# Exit code 77 where a program has skipped what prints a table and nothing else is wrong: that table was not compared.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"
build=$(cd "$OLDPWD" && cd "${1:?usage: check_figures.sh BUILD_FOLDER [--slow]}" && pwd) || exit 1
is_slow=${2-}
printed=(demos/scenes/README.md demos/experiments/README.md)

# Prints "FILE:LINE<tab>MARK" for every table of figures and everything measured, without a mark where there is none.
list_figures() {
    awk '
        function mark_above() { return last ~ /^<!-- figures: .* -->$/ ? substr(last, 15, length(last) - 18) : "" }
        function flush() {
            if (rows > 2 && figures >= 6 && !replaced) printf "%s:%d\t%s\n", FILENAME, first, mark
            if (rows) measured = ""
            rows = 0
        }
        FNR == 1 { inside = 0; rows = 0; last = ""; measured = ""; in_text = 0 }
        /^<!-- bsoil [a-z]+: / { inside = 1 }
        /^<!-- end -->/ { inside = 0 }
        /^\|/ {
            if (rows == 0) {
                first = FNR; figures = 0; replaced = inside
                mark = mark_above()
                if (mark == "") mark = measured
            }
            if (++rows > 2) {
                count = split($0, cells, /\|/)
                for (i = 3; i < count; ++i)
                    if (cells[i] ~ /^ *[-+*]*[0-9][-0-9., %x\/]*[*a-zA-Z\/%]* *$/) ++figures
            }
            last = $0
            next
        }
        { flush() }
        NF && !/^<!--/ && !in_text { # a paragraph begins
            in_text = 1
            measured = ""
            is_measured = FILENAME ~ /^docs\/decisions\// && /^\*\*(Measured|Price)/
            if (is_measured) { measured = mark_above(); from = FNR; text = "" }
        }
        is_measured && NF { text = text " " $0 }
        !NF {
            # A figure is a number with its unit or its place behind the point, not the name of a file.
            gsub(/`[^`]*`|\]\([^)]*\)/, "", text)
            if (is_measured && text ~ /[0-9]/) printf "%s:%d\t%s\n", FILENAME, from, measured
            in_text = is_measured = 0
        }
        NF { last = $0 }
        END { flush() }
    ' "$1"
}

# Prints "FILE:LINE<tab>MARK" for every paragraph with measured figures, without a mark where its section has had none.
list_sentences() {
    awk '
        function flush() {
            gsub(/`[^`]*`|\]\([^)]*\)|<!-- figure: [^>]*-->[^<]*<!-- \/ -->/, "", text)
            if (!inside && text ~ /[0-9] (%|ms|us|[kMG]B|frames a second|steps a second|steps\/s)([^a-zA-Z]|$)/)
                printf "%s:%d\t%s\n", FILENAME, from, mark
            text = ""
        }
        /^```/ { flush(); in_code = !in_code; next }
        in_code { next }
        /^<!-- bsoil [a-z]+: / { flush(); inside = 1 }
        /^<!-- end -->/ { flush(); inside = 0 }
        /^#/ { flush(); mark = "" }
        /^<!-- figures: .* -->$/ { flush(); above = $0; mark = substr($0, 15, length($0) - 18); if (mark ~ /^printed/) mark = ""; next }
        /^$/ || /^\|/ || /^ *([-*]|[0-9]+\.) / { flush() }
        /^<!--[^>]*-->$/ { next }
        # A row of a table with a line of its own is left to list_figures.
        /^\|/ { if (!in_table) is_named = above ~ /^<!-- figures: /; in_table = 1 }
        !/^\|/ { in_table = 0 }
        NF { above = $0 }
        in_table && is_named { next }
        NF { if (text == "") from = FNR; text = text " " $0 }
        END { flush() }
    ' "$1"
}

program_of() { find "$build/demos" "$build/tests" -maxdepth 2 -type f -name "$1" -perm -u+x | head -n 1; }

declare -A printed_by
skipped=0
# compare FILE LINE WORD...: the rows of the table at the line among what the program prints.
compare() {
    local file=$1 line=$2 program output row
    shift 2
    if [[ ! ${printed_by[$*]+is_there} ]]; then
        program=$(program_of "$1")
        [[ -n $program ]] || { fail "$file:$line: $1 is not in the build"; return; }
        printed_by[$*]=$("$program" "${@:2}" 2>&1)
    fi
    output=${printed_by[$*]}
    if [[ $output == *'[  SKIPPED ]'* || $output == 'no measured data in '* ]]; then
        printf '%s\n' "$file:$line: not compared: '$*' skips what prints them"
        skipped=1
        return
    fi
    while IFS= read -r row; do
        grep -qxF -- "$row" <<<"$output" || fail "$file: '$*' does not print
    $row"
    done < <(awk -v first="$line" 'FNR > first + 1 { if (!/^\|/) exit; print }' "$file")
}

# All tests, once: "Suite.test<tab>LINE" for each line of a test's text, up to the brace that closes it.
test_texts=$(mktemp)
trap 'rm -f "$test_texts"' EXIT
git ls-files -z 'tests/*.cpp' | xargs -0 awk '
    FNR == 1 { name = "" }
    match($0, /^TEST(_F|_P)?\([A-Za-z0-9_]+, [A-Za-z0-9_]+\)/) {
        name = substr($0, 1, RLENGTH - 1)
        sub(/^TEST(_F|_P)?\(/, "", name)
        sub(/, /, ".", name)
    }
    name { print name "\t" $0 }
    /^}/ || /^TEST.*}$/ { name = "" }' >"$test_texts"

# held_by PLACE Suite.test: BOUND...: each bound is a number in the test's text.
held_by() {
    local place=$1 name=${2%:} text bound
    text=$(grep -F -- "$name"$'\t' "$test_texts" | grep -- "^$name"$'\t' | cut -f 2-)
    [[ -n $text ]] || { fail "$place: no test $name"; return; }
    (($# > 2)) || fail "$place: which bounds of $name?"
    for bound in "${@:3}"; do
        grep -qE "(^|[^0-9.])${bound//./\\.}([^0-9.]|$)" <<<"$text" || fail "$place: $name has no $bound"
    done
}

# from_files PLACE FILE...: the numbers of the table or paragraph below the mark, units and all, are in one of the files.
from_files() {
    local file=${1%:*} line=${1##*:} source number text
    shift
    for source in "$@"; do
        [[ -f $source ]] || { fail "$file:$line: no file $source"; return; }
    done
    text=$(cat "$@")
    while IFS= read -r number; do
        grep -qE "(^|[^0-9.])${number//./\\.}([^0-9.]|\.?$|\.[^0-9])" <<<"$text" || fail "$file:$line: $number is not in $*"
    done < <(awk -v from="$line" 'FNR < from { next } !NF { exit } { print }' "$file" | sed -E 's/`[^`]*`|\]\([^)]*\)|<!--.*-->//g' |
        grep -oE '\b[0-9]+(\.[0-9]+)?( (m|mm|Pa|kPa|MPa|s|N|%)\b)?' | grep -E '\.| ' | sed 's/ .*//' | sort -u)
}

declare -A is_command
# check_source PLACE WORD...: a command of bsoil or a test, if it is one, is there. False where it is neither.
check_source() {
    local place=$1 name=${2%[,:]} command=${3-}
    case $name in
        bsoil)
            command=${command%[,:]}
            if [[ ! ${is_command[$command]+is_there} ]]; then
                "$(program_of bsoil)" "$command" --help >/dev/null 2>&1 && is_command[$command]=yes || is_command[$command]=
            fi
            [[ ${is_command[$command]} ]] || fail "$place: no command 'bsoil $command'"
            ;;
        [A-Z]*.*) grep -q -- "^${name/./\\.}" "$test_texts" || fail "$place: no test $name" ;;
        *) return 1 ;;
    esac
}

count=0
while IFS=$'\t' read -r place mark; do
    ((++count))
    read -ra words <<<"$mark"
    case $mark in
        '') fail "$place: figures without <!-- figures: ... --> above it" ;;
        'printed in minutes by '*)
            if [[ $is_slow ]]; then compare "${place%:*}" "${place##*:}" "${words[@]:4}"; fi ;;
        'printed by '*) compare "${place%:*}" "${place##*:}" "${words[@]:2}" ;;
        'held by '*) held_by "$place" "${words[@]:2}" ;;
        'from '*) from_files "$place" "${words[@]:1}" ;;
        'counted by '*) check_source "$place" "${words[2]}" || fail "$place: no test ${words[2]}" ;;
        'published, '*) ;;
        20[0-9][0-9]-[0-9][0-9]-[0-9][0-9]*)
            [[ $place == docs/decisions/* || $place == docs/records/* ]] ||
                fail "$place: a record of a day belongs into docs/decisions or docs/records"
            if [[ $mark == *,* ]]; then check_source "$place" "${words[@]:1}"; fi
            ;;
        *) fail "$place: what is '$mark'?" ;;
    esac
done < <(git ls-files '*.md' | while IFS= read -r page; do
    [[ " ${printed[*]} " == *" $page "* || $page == third_party_notes/* ]] && continue
    list_figures "$page"
    case $page in
        docs/decisions/* | docs/records/*) ;;
        README.md | plugin/README.md | bridge/README.md | docs/*.md) list_sentences "$page" ;;
    esac
done)
((count)) || fail "no figures found"
((failed == 0 && skipped)) && exit 77
exit "$failed"
