#!/usr/bin/env bash
# Checks what clang-format does not: lines of shaders and of the headers that they share with the host end at column 132, and
# no source file of the product is longer than 500 lines, tables aside.
set -uo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1
columns_most=132
lines_most=500
# Rows and no code.
tables=(demos/src/reading/scene_schema.cpp)
failed=0
fail() {
    printf '%s\n' "$*"
    failed=1
}

while IFS= read -r found; do
    fail "$found columns, at most $columns_most"
done < <(find shaders plugin/render/shaders tests/device/kernels -type f -print0 |
    xargs -0 awk -v most="$columns_most" 'length > most { print FILENAME ":" FNR ": " length }')

while read -r count file; do
    [[ $count -le $lines_most || " ${tables[*]} " == *" $file "* ]] || fail "$file: $count lines, at most $lines_most"
done < <(find plugin bridge shaders demos -type f \( -name '*.cpp' -o -name '*.h' -o -name '*.glsl' -o -name '*.c' \) -print0 |
    xargs -0 wc -l | grep -v ' total$')
exit "$failed"
