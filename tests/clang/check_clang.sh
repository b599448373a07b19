#!/usr/bin/env bash
# Checks that clang compiles what this build compiles, without a warning: check_clang.sh BUILD_FOLDER FOLDER...
# Every C++ source below the folders that the build knows is parsed, with its own flags; no code is made. 77: no clang.
set -euo pipefail
build=${1:?usage: check_clang.sh BUILD_FOLDER FOLDER...}
shift
command -v clang++ >/dev/null || exit 77

# check COMMAND: a line of compile_commands.json.
check() {
    local words
    mapfile -t words < <(xargs -n 1 printf '%s\n' <<<"$1")
    local arguments=() i
    for ((i = 0; i < ${#words[@]}; ++i)); do
        case ${words[i]} in
            -o | -include) ((++i)) ;;  # no precompiled headers: a source includes what it uses
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

commands=$(mktemp)
trap 'rm -f "$commands"' EXIT
for folder in "$@"; do
    # The sources of a static and a shared library, or of both precisions, are the same: one of each.
    sed -n 's/^ *"command": "\(.*\)",\{0,1\}$/\1/p' "$build/compile_commands.json" | sed 's/\\\(.\)/\1/g' |
        grep -E -- "-c $folder/[^ ]*\.cpp\$" | awk '!seen[$NF]++'
done >"$commands"
count=$(wc -l <"$commands")
((count)) || { printf 'no source below %s is compiled in %s\n' "$*" "$build"; exit 1; }
cd "$build"
xargs -d '\n' -P 2 -I COMMAND bash -c 'check "$1"' _ COMMAND <"$commands"
printf 'clang++ takes %d sources\n' "$count"
