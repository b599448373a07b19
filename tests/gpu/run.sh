#!/usr/bin/env bash
# The checks that need a hardware GPU: device and soil tests on OpenGL, then the same soils on the CPU and on the GPU,
# whose checksums have to be equal; then the figures of `bsoil bench` on the GPU, as a page.
#
#   tests/gpu/run.sh [--no-build] [--software] [--page FILE] [BUILD_DIR]
#
#   --no-build   take the programs that are in BUILD_DIR already (default: build/gpu)
#   --software   accept a software OpenGL: tries this script where there is no GPU, with few frames and small soils
#   --page FILE  where the page goes (default: BUILD_DIR/figures.md, and figures.json beside it)
#
# Exit code: 0 all equal, 1 something differs, 2 no hardware OpenGL or no build.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$root/build/gpu
do_build=1
software=0
page=
while (($#)); do
    case $1 in
        --no-build) do_build=0 ;;
        --software) software=1 ;;
        --page)
            page=${2:?--page needs a file}
            shift
            ;;
        -*)
            sed -n '2,12p' "$0" >&2
            exit 2
            ;;
        *) build=$1 ;;
    esac
    shift
done
page=${page:-$build/figures.md}

if ((do_build)); then
    cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release || exit 2
    cmake --build "$build" --parallel --target test_device test_soil bsoil || exit 2
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
# NVIDIA's driver keeps compiled kernels for everyone but root, unless it is told to. Compiling them takes many seconds.
export __GL_SHADER_DISK_CACHE=${__GL_SHADER_DISK_CACHE:-1} __GL_SHADER_DISK_CACHE_PATH=${__GL_SHADER_DISK_CACHE_PATH:-$build}

# run_tests NAME PROGRAM: a part of them on each core, with the results in $work/NAME.PART.json.
parts=$(nproc)
((parts <= 16)) || parts=16
run_tests() {
    local name=$1 program=$2 part pids=() pid
    for ((part = 0; part < parts; ++part)); do
        GTEST_TOTAL_SHARDS=$parts GTEST_SHARD_INDEX=$part "$program" --gtest_brief=1 \
            --gtest_output="json:$work/$name.$part.json" >"$work/$name.$part.log" 2>&1 &
        pids+=($!)
    done
    for pid in "${pids[@]}"; do wait "$pid" || failed=1; done
    grep -hv -e '^Running main' -e '^Note: ' -e '^$' "$work/$name".*.log || true
}

echo "== devices"
"$build/demos/bsoil" info

echo "== the kernels' language and buffers"
run_tests device "$build/tests/device/test_device"

echo "== the soil, stage by stage and whole"
run_tests soil "$build/tests/soil/test_soil"
# Determinism.gl_gives_the_bits_of_the_cpu records what it ran on and the checksums of its soils.
property() { sed -n "s/^ *\"$1\": \"\(.*\)\",\{0,1\}$/\1/p" "$work"/soil.*.json | head -n 1; }
device=$(property gl_device)
if [[ -z $device ]]; then
    echo "no OpenGL 4.5 device" >&2
    exit 2
fi
echo "OpenGL device: $device"
if ((!software)) && [[ $device =~ llvmpipe|softpipe|swrast|SwiftShader ]]; then
    echo "that is software; --software accepts it" >&2
    exit 2
fi

compare() { # name, CPU's checksum, GPU's
    local verdict=equal
    if [[ -z $2 || $2 != "$3" ]]; then
        verdict=DIFFERENT
        failed=1
    fi
    printf '%-24s cpu %s   gpu %s   %s\n' "$1" "${2:-none}" "${3:-none}" "$verdict"
}

echo "== checksums"
for seed in 4 5 6; do
    compare "moving scene $seed" "$(property "cpu_$seed")" "$(property "gl_$seed")"
done
# Short forms of all kinds of scenes: a column that falls, bodies that dig, drive and push.
for scene in column blocks scoop four_wheels excavator bulldozer; do
    for backend in cpu gl; do
        # A run's own checks may fail on so few steps (exit code 1); its summary is there all the same.
        "$build/demos/bsoil" run "$root/demos/scenes/$scene.toml" --backend $backend --steps 120 \
            --out "$work/$scene-$backend" >"$work/$scene-$backend.log" 2>&1 || true
    done
    checksum() { sed -n 's/.*"checksum": *"\([0-9a-f]*\)".*/\1/p' "$work/$scene-$1/summary.json" 2>/dev/null; }
    compare "scene $scene" "$(checksum cpu)" "$(checksum gl)"
done

echo "== figures"
if ((software)); then
    bench=(--backend gl --frames 3 --sides 16 --sides 24 --awake 24 --steps 5 --scene "$root/demos/scenes/blocks.toml")
else
    # 464^3 voxels are 10^8.
    bench=(--gpu --frames 60 --sides 56 64 72 80 88 104 128 256 --awake 100 216 464 --pictures 20
        --scene "$root/demos/scenes/excavator.toml" --scene "$root/demos/scenes/four_wheels.toml")
fi
"$build/demos/bsoil" bench "${bench[@]}" --page "$page" --out "${page%.md}.json" || failed=1
echo "the page: $page"
exit $failed
