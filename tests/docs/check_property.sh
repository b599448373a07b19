#!/usr/bin/env bash
# Follows docs/adding_a_property.md in a copy of the sources: check_property.sh FOLDER, where the copies and their builds
# go. The property is conserved to the unit, and everything else is what it is without it.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=${1:?a folder to work in}

# The page's patches, in its order. Their lines tell where they belong, not their line numbers.
patches() { sed -n '/^```diff$/,/^```$/{/^```/d;p}' "$root/docs/adding_a_property.md"; }

# run NAME: builds the property's program with the sources in FOLDER/NAME/sources and runs it.
run() {
    local log=$folder/$1.log
    cat >"$folder/$1/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(property LANGUAGES C CXX)
foreach(part BRIDGE RENDER DEMOS TESTS)
  set(BULLETSOIL_${part} OFF)
endforeach()
add_subdirectory(sources)
add_executable(property sources/tests/docs/property.cpp)
target_compile_features(property PRIVATE cxx_std_20)
target_include_directories(property PRIVATE sources/plugin/src sources/shaders)
target_link_libraries(property PRIVATE BulletSoil::soil)
END
    if ! { cmake -S "$folder/$1" -B "$folder/$1/build" -DCMAKE_BUILD_TYPE=Release -DCMAKE_POLICY_DEFAULT_CMP0077=NEW &&
        cmake --build "$folder/$1/build" --parallel 2 --target property; } >"$log" 2>&1; then
        tail -n 30 "$log" >&2
        exit 1
    fi
    "$folder/$1/build/property"
}

for name in as_it_is with_water; do
    rm -rf "$folder/$name/sources"
    mkdir -p "$folder/$name/sources"
    cp -rp "$root"/{CMakeLists.txt,plugin,shaders,docs,tests} "$folder/$name/sources"
done
patches | git -C "$folder/with_water/sources" apply -p1 || {
    echo "the patches of docs/adding_a_property.md do not apply" >&2
    exit 1
}

read -r none_before none_after others_without < <(run as_it_is)
read -r before after others_with < <(run with_water)
echo "without: water $none_before, everything else $others_without"
echo "with:    water $before, then $after, everything else $others_with"
[[ $before -gt 0 && $before == "$after" && $none_before == 0 && $none_after == 0 && $others_with == "$others_without" ]]
