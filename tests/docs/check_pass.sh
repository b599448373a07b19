#!/usr/bin/env bash
# Follows docs/adding_a_pass.md in the copy of the sources that check_property.sh has made and built: check_pass.sh FOLDER. What is
# not changed by the page is not compiled again. The page's own test is run, on both backends.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=${1:?the folder of check_property.sh}
sources=$folder/sources page=$root/docs/adding_a_pass.md log=$folder/pass.log
[[ -d $sources ]] || { printf '%s\n' "no $sources: docs.property makes it" >&2; exit 1; }

fail() {
    printf '%s\n' "$*" >&2
    exit 1
}

sed -n '/^```diff$/,/^```$/{/^```/d;p}' "$page" | git -C "$sources" apply -p1 || fail "the patches of $page do not apply"
cat >>"$folder/CMakeLists.txt" <<'END'
find_package(GTest REQUIRED)
add_executable(pass sources/tests/soil/drag_falling_test.cpp sources/tests/soil/soil_fixture.cpp)
target_include_directories(pass PRIVATE sources/tests sources/plugin/src sources/shaders)
target_link_libraries(pass PRIVATE BulletSoil::soil GTest::gtest_main)
END
while IFS= read -r file; do
    awk -v mark="<!-- tested as $file -->" '
        $0 == mark { found = 1; next }
        found && /^```/ { found = !inside; inside = !inside; next }
        inside' "$page" >"$sources/$file"
done < <(sed -nE 's/^<!-- tested as (.*) -->$/\1/p' "$page")

# Configured first, since the program is new to the folder.
build() {
    { cmake "$folder/build" && cmake --build "$folder/build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-1}" --target pass; } >"$log" 2>&1 ||
        fail "$(tail -n 30 "$log")"
}
build
"$folder/build/pass" | tee "$log"
grep -q '\[  PASSED  \] 1 test' "$log" || { grep -q SKIPPED "$log" && exit 77; fail "the page's test was not run"; }

# Without its call the pass does nothing, and the test says so.
sed -i '/Kernel::drag_falling/d' "$sources/plugin/src/soil/passes.cpp"
build
! "$folder/build/pass" >"$log" || fail "the page's test passes without the pass"
grep -q 'Expected: (speed_m_s) <' "$log" || fail "$(cat "$log")"
