#!/usr/bin/env bash
# Checks that every link between the project's own pages and files leads somewhere.
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
exit "$failed"
