#!/usr/bin/env bash
# Fuzzes the readers and the interfaces: tests/fuzz/run.sh [--minutes M] [--jobs N] [TARGET...]
# Builds with clang, libFuzzer and the sanitizers for memory and undefined behaviour, in a folder of its own; then runs each
# target, or those named, for M minutes of processor time (1), N at a time (1). What it learns is kept in build-fuzz/corpus for
# the next time. A finding ends its target, and the rest go on; the input lies in build-fuzz/findings. Each run adds a line to
# build-fuzz/ledger: day, commit, target, seconds of processor time, runs, and clean or found. Exit codes: 0 nothing found,
# 1 something found or not built, 2 bad arguments, 77 clang is not there.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../demos/setup.sh"

minutes=1 jobs=1
while [[ ${1:-} == --* ]]; do
    case $1 in
        --minutes) minutes=${2:-} ;;
        --jobs) jobs=${2:-} ;;
        *) say "usage: tests/fuzz/run.sh [--minutes M] [--jobs N] [TARGET...]"; exit 2 ;;
    esac
    [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || { say "$1 needs a whole number, 1 or more"; exit 2; }
    shift 2
done
here=$project_root/tests/fuzz
targets=("$@")
((${#targets[@]})) || for folder in "$here"/seeds/*/; do targets+=("$(basename "$folder")"); done
for target in "${targets[@]}"; do
    [[ -d $here/seeds/$target ]] || { say "There is no target $target; these are: $(ls "$here/seeds" | xargs)"; exit 2; }
done

install_packages "${build_packages[@]}" "${test_packages[@]}" "${fuzz_packages[@]}" || exit 77
folder=$project_root/build-fuzz
configure "$folder" CMAKE_C_COMPILER=clang CMAKE_CXX_COMPILER=clang++ BULLETSOIL_TESTS=ON BULLETSOIL_FUZZ=ON \
    BULLETSOIL_WERROR=ON BULLETSOIL_RENDER=OFF BULLETSOIL_SANITIZE=address,undefined CMAKE_BUILD_TYPE?=RelWithDebInfo \
    "CMAKE_CXX_FLAGS_RELWITHDEBINFO?=-O1 -g1"
build "$folder" bulletsoil_fuzz

export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_stack_use_after_return=0} UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$here/leaks.supp:print_suppressions=0
mkdir -p "$folder/findings"
commit=$(git -C "$project_root" describe --always --dirty 2>/dev/null || echo unknown)

# words PAGE: the tables and keys that a page of keys names, as libFuzzer takes words.
words() { sed -nE 's/^## (\[.*\])$/"\1"/p; s/^\| `([a-z_0-9]+)` .*/"\1 = "/p' "$1" | sort -u; }
words "$project_root/demos/scenes/README.md" >"$folder/scene.dict"
words "$project_root/demos/experiments/README.md" >"$folder/experiment.dict"
cp "$here/urdf.dict" "$folder/urdf.dict"

# fuzz TARGET: 1 where something is found. libFuzzer counts seconds on the wall, so it is asked again until those of the processor
# are spent: an hour is an hour, whatever runs beside it.
fuzz() {
    local target=$1 log=$folder/$1.log spent=0 runs=0 result=clean seconds TIMEFORMAT='%U %S'
    local options=(-timeout=600 -rss_limit_mb=3000 -max_len=65536 -print_final_stats=1 -close_fd_mask=1
        -artifact_prefix="$folder/findings/$target-")
    [[ -f $folder/$target.dict ]] && options+=(-dict="$folder/$target.dict")
    # What steps a soil runs through so much of the code that weighing inputs by how rare their features are takes longer than
    # the runs do: without it they are twice as many a minute, and find as much a run.
    [[ $target == *_calls || $target == soil_state || $target == world_snapshot ]] && options+=(-entropic=0)
    mkdir -p "$folder/corpus/$target"
    while [[ $result == clean ]] && ((spent < 60 * minutes)); do
        seconds=$((60 * minutes - spent))
        { time BSOIL_FUZZ_TARGET=$target "$folder/tests/fuzz/bulletsoil_fuzz" "${options[@]}" \
            -max_total_time=$((seconds > 10 ? seconds : 10)) \
            "$folder/corpus/$target" "$here/seeds/$target" >"$log" 2>&1; } 2>"$folder/$target.time" || result=found
        spent=$((spent + $(awk '{ printf "%d", $1 + $2 + 0.999 }' "$folder/$target.time")))
        runs=$((runs + $(sed -nE 's/^stat::number_of_executed_units: *//p' "$log" | grep . || echo 0)))
    done
    printf '%s %s %s %d %d %s\n' "$(date -u +%F)" "$commit" "$target" "$spent" "$runs" "$result" >>"$folder/ledger"
    if [[ $result == clean ]]; then
        say "$target: nothing found in $runs runs and $spent s, $(sed -nE 's/^stat::peak_rss_mb: *//p' "$log") MB"
        return
    fi
    say "$target: found something; $log"
    grep -aE 'FOUND|ERROR|runtime error|SUMMARY|Test unit written' "$log" >&2 || tail -n 20 "$log" >&2
    return 1
}

found=0
for target in "${targets[@]}"; do
    while (($(jobs -rp | wc -l) >= jobs)); do wait -n || found=1; done
    fuzz "$target" &
done
while (($(jobs -p | wc -l) > 0)); do wait -n || found=1; done
exit "$found"
