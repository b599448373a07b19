#!/usr/bin/env bash
# Checks what clang-format does not: lines of shaders and of the headers that they share with the host end at column 132,
# no source file is longer than 500 lines, tables aside, and a body that starts on a line of its own has braces. Tests stand in
# files named NAME_test.cpp, no two alike. No kernel has a loop without an end in its head: docs/decisions/gpu_programs.md.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"
columns_most=132
lines_most=500
# Rows and no code.
tables=(demos/src/reading/scene_schema.cpp)

while IFS= read -r found; do
    fail "$found columns, at most $columns_most"
done < <(find shaders plugin/render/shaders tests/device/kernels -type f -print0 |
    xargs -0 awk -v most="$columns_most" 'length > most { print FILENAME ":" FNR ": " length }')

while read -r count file; do
    [[ $count -le $lines_most || " ${tables[*]} " == *" $file "* ]] || fail "$file: $count lines, at most $lines_most"
done < <(git ls-files -z '*.cpp' '*.h' '*.glsl' '*.frag' '*.vert' '*.c' '*.sh' '*.cmake' '*CMakeLists.txt' | xargs -0 wc -l | grep -v ' total$')

while IFS= read -r found; do
    fail "$found: a GPU's compiler may not find its end"
done < <(git grep -nF 'for (;;)' -- 'shaders/*.glsl' 'tests/device/kernels/*.glsl')

while IFS= read -r file; do
    [[ $file == *_test.cpp ]] || fail "$file: has tests, so its name must end in _test.cpp"
done < <(git grep -lE '^(TEST|TEST_F|TEST_P|TYPED_TEST)\(' -- '*.cpp')
while IFS= read -r name; do
    fail "two files of tests are called $name"
done < <(git ls-files '*_test.cpp' | sed 's,.*/,,' | sort | uniq -d)

# A control statement's line is joined until its brackets close; then it may end with its brace or with its whole body.
while IFS= read -r found; do
    fail "$found: a body on a line of its own needs braces"
done < <(git ls-files -z '*.cpp' '*.h' '*.c' '*.glsl' '*.frag' '*.vert' | xargs -0 awk '
    FNR == 1 { open = 0; depth = 0 }
    {
        line = $0
        gsub(/"([^"\\]|\\.)*"|\047([^\047\\]|\\.)\047/, "text", line)
        sub(/[ \t]*\/\/.*/, "", line)
    }
    !open && line ~ /^[ \t]*((} )?else )?(if|for|while)( constexpr)? \(/ { open = 1; depth = 0; at = FNR }
    line ~ /^[ \t]*(} )?else$/ { print FILENAME ":" FNR }
    open {
        depth += gsub(/\(/, "(", line) - gsub(/\)/, ")", line)
        if (depth == 0) {
            if (line ~ /\)$/) print FILENAME ":" at
            open = 0
        }
    }')
exit "$failed"
