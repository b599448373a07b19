#!/usr/bin/env bash
# Checks that every link between the project's own pages and files leads somewhere, and that README.md links every program
# that is there to be read.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
failed=0
while IFS= read -r page; do
    while IFS= read -r link; do
        target=${link%%#*}
        [[ -z $target || $target == *://* || -e $(dirname "$page")/$target ]] && continue
        printf '%s: %s is not there\n' "${page#"$root"/}" "$link"
        failed=1
    done < <(grep -oE '\]\([^) ]+\)' "$page" | sed -E 's/^\]\((.*)\)$/\1/')
done < <(find "$root" -name '*.md' -not -path '*/build*' -not -path '*/out*' -not -path '*/.git/*')
while IFS= read -r program; do
    [[ $program == */main.cpp ]] && continue # the command bsoil
    grep -qF "](${program#"$root"/})" "$root/README.md" && continue
    printf 'README.md does not link %s\n' "${program#"$root"/}"
    failed=1
done < <(grep -l '^int main' "$root"/demos/src/*/*.cpp)
exit "$failed"
