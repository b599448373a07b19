#!/usr/bin/env bash
# Shows that a change of the code changes no result: builds a commit and the work tree, runs the same scenes and
# experiments with both, and compares what they leave behind byte by byte.
#
#   tests/same_bytes/run.sh [OPTION...] BASE [NAME...]
#
#   BASE          a commit, e.g. origin/main or HEAD; its sources are built in build-same-bytes/<commit>, once
#   NAME          a scene out of demos/scenes or an experiment out of demos/experiments, without .toml; all where none is given
#   --steps N     steps of a scene; without it each has a number in which its bodies meet the soil (see short_steps)
#   --long        scenes to their end, and all experiments of docs/validation.md
#   --backend B   cpu (the default) or gl
#   --new NAME    a scene or experiment that BASE does not have yet; any other that it lacks counts as a difference. Again for more
#   --no-build    take the two programs as they are
#
# Compared are a scene's checksum (the soil, to the unit) and its telemetry.csv (bodies, forces and loads, by row), and an
# experiment's table of results. Snapshots are not: Bullet's broadphase orders its tree by addresses, so that a program
# that allocates something else in between writes another one. A scene needs the data it names (BULLETSOIL_DATA), else it
# is skipped.
# Exit code: 0 the same bytes, 1 a difference, 2 could not build or run, or nothing was compared.
set -uo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../demos/setup.sh"

steps= long=0 backend=cpu do_build=1 base= names=() new=()
usage() {
    sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}" >&2
    exit 2
}
while (($#)); do
    case $1 in
        --steps | --backend | --new)
            [[ $# -gt 1 ]] || usage
            case $1 in
                --steps) steps=$2 ;;
                --backend) backend=$2 ;;
                --new) new+=("$2") ;;
            esac
            shift
            ;;
        --long) long=1 ;;
        --no-build) do_build=0 ;;
        -*) usage ;;
        *) if [[ -z $base ]]; then base=$1; else names+=("$1"); fi ;;
    esac
    shift
done
[[ -n $base ]] || usage
commit=$(git -C "$project_root" rev-parse --verify --quiet "$base^{commit}") || {
    say "$base is no commit"
    exit 2
}

# Steps of a scene's short form: until its bodies stand in the soil and have moved some of it. 120 where none is given.
declare -A short_steps=([scoop]=300 [terrain]=60 [thin_bucket]=300 [zx200]=60)
# Experiments of the short form: a minute or so each.
short_experiments=(cullinan_shear)

base_tree=$project_root/build-same-bytes/${commit:0:12}
out=$project_root/build-same-bytes/out
work_build=$project_root/build
base_program=$base_tree/build/demos/bsoil
work_program=$work_build/demos/bsoil

# The value of a variable in the work tree's build, as NAME=VALUE; nothing where it has none.
cached() { sed -n "s/^$1:[A-Z]*=\(.\)/$1=\1/p" "$work_build/CMakeCache.txt"; }

if ((do_build)); then
    configure "$work_build" CMAKE_BUILD_TYPE?=Release && build "$work_build" bsoil || exit 2
    # Files are written once: what is there already keeps its time, and is not compiled again.
    if [[ ! -f $base_tree/CMakeLists.txt ]]; then
        rm -rf "$base_tree.part"
        mkdir -p "$base_tree.part"
        git -C "$project_root" archive "$commit" | tar -x -C "$base_tree.part" && mv "$base_tree.part" "$base_tree" || exit 2
    fi
    # Built alike, or the compiler makes the difference.
    read -ra options <<<"$(cached CMAKE_BUILD_TYPE) $(cached BULLETSOIL_WERROR) $(cached BULLETSOIL_SANITIZE)"
    (project_root=$base_tree && configure "$base_tree/build" BULLETSOIL_TESTS=OFF "${options[@]}") || exit 2
    build "$base_tree/build" bsoil || exit 2
fi

failed=0 compared=0
row() { printf '%-24s %-9s %-36s %s\n' "$@"; }

# verdict A B: are the two files the same? Sets $verdict.
verdict() {
    if [[ ! -f $1 && ! -f $2 ]]; then
        verdict=-
    elif cmp -s "$1" "$2"; then
        verdict=equal
    else
        verdict=DIFFERENT
        failed=1
    fi
}

# The first line and column in which two tables with a head line differ.
first_difference() {
    awk -F, 'NR == FNR { line[FNR] = $0; if (FNR == 1) split($0, name, ","); next }
             $0 != line[FNR] {
                 split(line[FNR], old, ",")
                 for (i = 1; i <= NF && $i == old[i]; ++i);
                 printf "    line %d, %s %s: %s was %s\n", FNR, $1, name[i], $i, old[i]
                 exit
             }' "$1" "$2"
}

# both KIND NAME COMMAND...: runs the command with both programs at the same time; PROGRAM, TREE and OUT in it stand for
# the side's own. False where one could not run.
both() {
    local kind=$1 name=$2 side program tree word codes=() jobs=()
    shift 2
    for side in base tree; do
        if [[ $side == base ]]; then program=$base_program tree=$base_tree; else program=$work_program tree=$project_root; fi
        local folder=$out/$side/$name command=()
        rm -rf "$folder"
        mkdir -p "$folder"
        for word in "$@"; do
            word=${word/#PROGRAM/$program}
            word=${word/#TREE/$tree}
            command+=("${word/#OUT/$folder}")
        done
        "${command[@]}" >"$folder/log" 2>&1 &
        jobs+=($!)
    done
    for side in 0 1; do
        wait "${jobs[$side]}"
        codes+=($?)
    done
    if [[ ${codes[0]} == 77 && ${codes[1]} == 77 ]]; then
        row "$name" skipped "its data is not there" -
        return 1
    fi
    # 1: a check of the scene or a gate of the experiment fails; what was left behind is compared all the same.
    if ((codes[0] > 1 || codes[1] > 1)); then
        row "$name" "could not" "base: ${codes[0]}, work tree: ${codes[1]}" -
        say "    $kind $name: $(tail -n 1 "$out/base/$name/log"); $(tail -n 1 "$out/tree/$name/log")"
        failed=1
        return 1
    fi
    compared=$((compared + 1))
}

# not_in_base NAME: that is a difference, unless the scene is said to be new.
not_in_base() {
    if [[ " ${new[*]} " == *" $1 "* ]]; then
        row "$1" - "new" -
    else
        row "$1" - "not in base" DIFFERENT
        failed=1
    fi
}

checksum() { sed -n 's/.*"checksum": *"\([0-9a-f]*\)".*/\1/p' "$out/$1/$2/summary.json"; }
ran_steps() { sed -n 's/.*"steps": *\([0-9]*\).*/\1/p' "$out/tree/$1/summary.json"; }

compare_scene() {
    local name=$1 count=${steps:-${short_steps[$1]:-120}} old new sum
    local limit=(--steps "$count")
    if ((long)) && [[ -z $steps ]]; then limit=(); fi
    both scene "$name" PROGRAM run "TREE/demos/scenes/$name.toml" --out OUT --no-pictures --backend "$backend" --threads 1 \
        "${limit[@]}" || return
    old=$(checksum base "$name") new=$(checksum tree "$name") sum=$new
    if [[ -z $new || $old != "$new" ]]; then
        sum="${old:-none} -> ${new:-none}"
        failed=1
    fi
    verdict "$out/base/$name/telemetry.csv" "$out/tree/$name/telemetry.csv"
    row "$name" "$(ran_steps "$name")" "$sum" "$verdict"
    if [[ $verdict == DIFFERENT ]]; then first_difference "$out/base/$name/telemetry.csv" "$out/tree/$name/telemetry.csv"; fi
}

compare_experiment() {
    local name=$1 table
    both experiment "$name" PROGRAM validate --experiments TREE/demos/experiments --only "$name" --out OUT --threads 1 || return
    table=$out/tree/$name/$name.csv
    verdict "$out/base/$name/$name.csv" "$table"
    row "$name" - "$(sha256sum <"$table" | cut -c 1-16) of the table" "$verdict"
    if [[ $verdict == DIFFERENT ]]; then first_difference "$out/base/$name/$name.csv" "$table"; fi
}

scenes=() experiments=()
if ((${#names[@]} == 0)); then
    for file in "$project_root"/demos/scenes/*.toml; do scenes+=("$(basename "$file" .toml)"); done
    experiments=("${short_experiments[@]}")
    if ((long)); then
        # Those of docs/validation.md.
        for file in $(grep -l '^\[validation\]' "$project_root"/demos/experiments/*.toml); do
            experiments+=("$(basename "$file" .toml)")
        done
        mapfile -t experiments < <(printf '%s\n' "${experiments[@]}" | sort -u)
    fi
fi
for name in "${names[@]}"; do
    if [[ -f $project_root/demos/scenes/$name.toml ]]; then
        scenes+=("$name")
    elif [[ -f $project_root/demos/experiments/$name.toml ]]; then
        experiments+=("$name")
    else
        say "$name is neither a scene nor an experiment"
        exit 2
    fi
done

echo "base ${commit:0:12}, backend $backend"
row scene steps checksum telemetry
row ----- ----- -------- ---------
for name in "${scenes[@]}"; do
    if [[ -f $base_tree/demos/scenes/$name.toml ]]; then
        compare_scene "$name"
    else
        not_in_base "$name"
    fi
done
for name in "${experiments[@]}"; do
    if [[ -f $base_tree/demos/experiments/$name.toml ]]; then
        compare_experiment "$name"
    else
        not_in_base "$name"
    fi
done

if ((failed)); then
    echo "DIFFERENT; what both left behind: $out"
    exit 1
fi
if ((compared == 0)); then
    echo "nothing was compared"
    exit 2
fi
echo "$compared compared: the same bytes"
