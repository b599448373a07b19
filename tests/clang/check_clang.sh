#!/usr/bin/env bash
# Checks that clang compiles what this build compiles, without a warning: check_clang.sh BUILD_FOLDER FOLDER...
# Every C++ source below the folders that the build knows is parsed with its own flags, many at once, since most of what is parsed
# are headers that they share; no code is made. The target CLANG_LEAVES_OUT is left out. 77: no clang.
set -euo pipefail
built=${1:?usage: check_clang.sh BUILD_FOLDER FOLDER...}
shift
command -v clang++ >/dev/null || exit 77

# The same build again; nothing is compiled in it.
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
mapfile -t options < <(sed -n 's/^\(BULLETSOIL_[A-Z_]*\|CMAKE_BUILD_TYPE\|BUILD_SHARED_LIBS\):[A-Z]*=/-D\1=/p' "$built/CMakeCache.txt")
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cmake -S "$root" -B "$build" "${options[@]}" -DBULLETSOIL_UNITY=ON -DBULLETSOIL_UNITY_SIZE=40 >"$build/log" 2>&1 || { cat "$build/log"; exit 1; }

# check COMMAND: a line of compile_commands.json.
check() {
    local words
    mapfile -t words < <(xargs printf '%s\n' <<<"$1")
    local arguments=() i
    for ((i = 0; i < ${#words[@]}; ++i)); do
        case ${words[i]} in
            -o | -include) ((++i)) ;;  # nothing is included but what the source asks for
            *ccache | *c++ | *g++ | *g++-[0-9]* | -O[0-9s] | -Werror | -Winvalid-pch | -fsanitize*) ;;
            *) arguments+=("${words[i]}") ;;
        esac
    done
    clang++ -Werror -fsyntax-only "${arguments[@]}" || {
        printf 'clang++ refuses %s\n' "${words[-1]}"
        return 1
    }
}
export -f check

commands=$build/commands
for folder in "$@"; do
    # What is left out of such groups may be in both libraries, static and shared: one of each.
    sed -n 's/^ *"command": "\(.*\)",\{0,1\}$/\1/p' "$build/compile_commands.json" | sed 's/\\\(.\)/\1/g' |
        grep -E -- "-c ($folder/[^ ]*\.cpp|$build/${folder#"$root/"}/[^ ]*/Unity/[^ ]*\.cxx)\$" |
        grep -vF -- "/${CLANG_LEAVES_OUT:-no such folder}.dir/" | awk '!seen[$NF]++'
done >"$commands"
count=$(wc -l <"$commands")
grep -q /Unity/ "$commands" && ((count)) || { printf 'no source below %s is compiled in %s\n' "$*" "$build"; exit 1; }
cd "$build"
xargs -d '\n' -P 2 -I COMMAND bash -c 'check "$1"' _ COMMAND <"$commands"
printf 'clang++ takes %d compilations\n' "$count"
