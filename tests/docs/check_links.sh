#!/usr/bin/env bash
# Checks that every link between the project's own pages and files leads somewhere, to a heading where it names one, and that
# README.md links every program that is there to be read.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"

# The places of a page that a link can name: its headings as GitHub spells them, and anchors put in by hand.
places() {
    sed '/^```/,/^```/d' "$1" | sed -nE 's/^#+ +//p' | tr 'A-Z' 'a-z' | sed -E 's/\]\([^)]*\)//g; s/[^a-z0-9 _-]//g; s/ /-/g'
    grep -oE '<a (id|name)="[^"]+"' "$1" | sed -E 's/.*"(.*)"/\1/'
}

# Each page's places once, however many links lead there.
declare -A places_of=()
while IFS= read -r page; do
    while IFS= read -r link; do
        link=${link#](} link=${link%)}
        target=${link%%#*} place=${link#"${link%%#*}"} file=${page%/*}/${link%%#*}
        [[ $target == *://* ]] && continue
        [[ -n $target ]] || file=$page
        if [[ -e $file ]]; then
            [[ -z $place || $file != *.md ]] && continue
            [[ -v places_of[$file] ]] || places_of[$file]=$'\n'$(places "$file")$'\n'
            [[ ${places_of[$file]} == *$'\n'"${place#\#}"$'\n'* ]] && continue
        fi
        fail "${page#./}: $link is not there"
    done < <(grep -oE '\]\([^) ]+\)' "$page")
done < <(find . -name '*.md' -not -path './build*/*' -not -path './out*/*' -not -path './.git/*')
while IFS= read -r program; do
    [[ $program == */main.cpp ]] && continue # the command bsoil
    grep -qF "]($program)" README.md || fail "README.md does not link $program"
done < <(grep -l '^int main' demos/src/*/*.cpp)
exit "$failed"
