#!/usr/bin/env bash
# Follows docs/adding_a_property.md in a copy of the sources: check_property.sh FOLDER PROGRAM, where the copy and its build go
# and the property's program built with the sources as they are. The copy is built without optimization, which takes a fifth of
# the time, and with clang where it is installed, which takes a third less. Neither changes a bit of the soil. The property is
# conserved to the unit, everything else is what it is without it; the parameter is checked, saved, used, a key of scenes and a
# member in C.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=${1:?a folder to work in} as_it_is=${2:?the program as it is}
sources=$folder/sources log=$folder/log

# The page's patches, in its order. Their lines tell where they belong, not their line numbers.
patches() { sed -n '/^```diff$/,/^```$/{/^```/d;p}' "$root/docs/adding_a_property.md"; }

fail() {
    printf '%s\n' "$*" >&2
    exit 1
}

rm -rf "$folder"
mkdir -p "$sources"
cp -rp "$root"/{CMakeLists.txt,plugin,shaders,bridge,demos,docs,tests} "$sources"
patches | git -C "$sources" apply -p1 || fail "the patches of docs/adding_a_property.md do not apply"

cat >"$folder/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(property LANGUAGES C CXX)
foreach(part BRIDGE RENDER DEMOS TESTS)
  set(BULLETSOIL_${part} OFF)
endforeach()
set(BULLETSOIL_UNITY_SIZE 100)
add_subdirectory(sources)
# What check_pass.sh compiles again: what knows the kernels by name.
foreach(name flows passes water)
  set_source_files_properties(sources/plugin/src/soil/${name}.cpp TARGET_DIRECTORY bulletsoil_soil
                              PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endforeach()
set(CMAKE_CXX_STANDARD 20)
add_executable(property sources/tests/docs/property.cpp)
target_include_directories(property PRIVATE sources/plugin/src sources/shaders)
target_link_libraries(property PRIVATE BulletSoil::soil)
# What of the scenes knows a material's fields.
find_path(TOMLPLUSPLUS_INCLUDE_DIR toml++/toml.h REQUIRED)
add_executable(property_keys sources/tests/docs/property_keys.cpp)
foreach(name scene/rotations scene/scene scene/scene_error reading/schema_table reading/soil_schema)
  target_sources(property_keys PRIVATE sources/demos/src/${name}.cpp)
endforeach()
target_include_directories(property_keys PRIVATE sources/demos/src ${TOMLPLUSPLUS_INCLUDE_DIR})
target_link_libraries(property_keys PRIVATE BulletSoil::soil fmt::fmt)
# And of the C interface.
find_package(PkgConfig REQUIRED)
pkg_check_modules(BULLET REQUIRED IMPORTED_TARGET bullet)
add_library(property_c OBJECT sources/bridge/src/c_structs.cpp)
target_include_directories(property_c PRIVATE sources/bridge/include sources/bridge/src)
target_link_libraries(property_c PRIVATE BulletSoil::soil PkgConfig::BULLET)
target_compile_definitions(property_c PRIVATE BULLETSOIL_SCALAR_BITS=32)
END
compiler=()
! command -v clang++ >/dev/null || compiler=(-DCMAKE_CXX_COMPILER=clang++)
if ! { cmake -S "$folder" -B "$folder/build" -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_FLAGS_DEBUG=-O0 -DBULLETSOIL_UNITY=ON \
    "${compiler[@]}" \
    -DCMAKE_POLICY_DEFAULT_CMP0077=NEW &&
    cmake --build "$folder/build" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-1}" --target property property_keys property_c; } >"$log" 2>&1; then
    tail -n 30 "$log" >&2
    exit 1
fi

read -r none_before none_after others_without parameter_without < <("$as_it_is")
read -r before after others_with parameter < <("$folder/build/property")
echo "without: salt $none_before, everything else $others_without, the parameter: $parameter_without"
echo "with:    salt $before, then $after, everything else $others_with, the parameter: $parameter"
[[ $before -gt 0 && $before == "$after" && $none_before == 0 && $none_after == 0 ]] || fail "salt is not kept"
[[ $others_with == "$others_without" ]] || fail "salt changes something else"
[[ $parameter_without == none && $parameter == checked_saved_used ]] || fail "the parameter is not known everywhere"
"$folder/build/property_keys" | grep -F '| `salt_fraction` | number | 0 .. 0.5 | - |' || fail "scenes do not know the parameter"

# Without its member in C the table's row does not compile.
grep -v salt_fraction "$sources/bridge/include/bsoil/c/bulletsoil.h" >"$folder/bulletsoil.h"
mv "$folder/bulletsoil.h" "$sources/bridge/include/bsoil/c/bulletsoil.h"
! cmake --build "$folder/build" --target property_c >"$log" 2>&1 || fail "a row without its member in C compiles"
grep -q "no member named .salt_fraction" "$log" || fail "$(tail -n 5 "$log")"
