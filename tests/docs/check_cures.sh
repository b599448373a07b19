#!/bin/bash
# Usage: check_cures.sh
# Every text with which the library or the command line refuses something says what may be, or what to do: tests/cure.h has
# the words. Looked at are the literals of Error{...}, throw ...(...), refuse(...) and the like, put together. A text that ends
# with a colon and somebody else's reason is theirs to end.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"

words_of() { # NAME: the words of that list, as a regular expression
    awk -v name="$1" '
        $0 ~ name "\\[\\] = \\{" { inside = 1 }
        inside {
            while (match($0, /"[^"]*"/)) {
                printf "%s%s", sep, substr($0, RSTART + 1, RLENGTH - 2)
                sep = "|"
                $0 = substr($0, RSTART + RLENGTH)
            }
            if (/\};/) exit
        }' tests/cure.h
}
ranges=$(words_of kRangeWords) orders=$(words_of kOrderWords)
# Somebody else's reason, or one of the file's keys and that.
theirs='(: |\\n|, |\.)(\{\})?$|^[^ ]+: [a-z_]*(\{\})?$'
[[ $ranges == *must* && $orders == *write* ]] || fail "tests/cure.h has no words"

# Prints "FILE:LINE: TEXT" of each refusal.
list_refusals() {
    awk '
        function flush_file(   rest, line, start, head, before) {
            rest = source
            line = 1
            while (match(rest, starts)) {
                head = substr(rest, 1, RSTART + RLENGTH - 1)
                before = RSTART > 1 ? substr(rest, RSTART - 1, 1) : " "
                line += gsub(/\n/, "\n", head)
                rest = substr(rest, RSTART + RLENGTH)
                if (before ~ /[A-Za-z0-9_]/) continue
                # Lists of other things begin otherwise.
                if (head ~ /return \{$/ && rest !~ /^(fmt::format\()?"[^"]* /) continue
                read_text(rest, line)
            }
        }
        function read_text(rest, line,   depth, text, gap, token, has_plus) {
            depth = 1
            text = ""
            while (depth > 0 && match(rest, /"([^"\\]|\\.)*"|[][(){};]/)) {
                gap = substr(rest, 1, RSTART - 1)
                token = substr(rest, RSTART, RLENGTH)
                rest = substr(rest, RSTART + RLENGTH)
                if (gap ~ /\+/) has_plus = 1
                # What stands there is an order.
                if (gap ~ /kTakeAnotherCopy|[^a-z]cure/) text = text "; take it"
                if (token ~ /^"/) {
                    if (text != "" && has_plus) text = text "{}"
                    text = text substr(token, 2, length(token) - 2)
                    has_plus = 0
                } else if (token ~ /[[({]/) {
                    ++depth
                } else if (token == ";") {
                    # A declaration, or the statement has ended.
                    depth = 0
                } else {
                    --depth
                }
            }
            if (has_plus) text = text "{}"
            if (text != "") print file ":" line ": " text
        }
        BEGIN {
            starts = "(Error|Failure|Fault|ValidationError|runtime_error)[ \n]*[({]|" \
                     "(refuse|refusal|fail|error|wrong|could_not)\\(|return \\{"
        }
        FNR == 1 {
            if (file != "") flush_file()
            file = FILENAME
            source = ""
        }
        {
            if ($0 ~ /^ *(\/\/|\*|#include)/) $0 = ""
            sub(/  \/\/.*$/, "")
            source = source $0 "\n"
        }
        END { flush_file() }' "$@"
}

mapfile -t sources < <(git ls-files plugin bridge demos | grep -E '\.(cpp|h)$')
refusals=$(list_refusals "${sources[@]}")
count=$(wc -l <<<"$refusals")
((count > 400)) || fail "only $count texts found"
while IFS= read -r found; do
    [[ $found ]] && fail "$found: says neither what may be nor what to do"
done < <(grep -vE "($ranges)|([;:,.] |\})(or |please |then )?($orders)([^a-z]|\$)|$theirs" <<<"$refusals")
exit "$failed"
