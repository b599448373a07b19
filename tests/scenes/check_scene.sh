#!/usr/bin/env bash
# One test of the `bsoil` command:
#   check_scene.sh BSOIL SCRATCH passes SCENE [VOXEL_M]
#   check_scene.sh BSOIL SCRATCH starts_well SCENE STEPS CHECKS
#   check_scene.sh BSOIL SCRATCH same_bits SCENE STEPS GL_STEPS UP_TOLERANCE_UM [VOXEL_M]
#   check_scene.sh BSOIL SCRATCH restarts SCENE STEPS AT
#   check_scene.sh BSOIL SCRATCH cli_CASE
# SCRATCH is emptied first. Exit codes: 0 passed, 1 failed, 77 skipped (the scene's data or OpenGL is not there).
set -uo pipefail
export LC_ALL=C

bsoil=$1 scratch=$2 test_case=$3
shift 3
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch" || exit 1

fail() {
    printf 'FAIL %s\n' "$*"
    exit 1
}

skip() {
    printf 'SKIP %s\n' "$*"
    exit 77
}

# expect EXIT_CODE BSOIL_ARGUMENTS...: leaves what bsoil printed in the file `log`.
expect() {
    local wanted=$1 code=0
    shift
    "$bsoil" "$@" >log 2>&1 || code=$?
    [[ $code == "$wanted" ]] && return
    cat log
    [[ $code == 77 ]] && exit 77
    fail "exit code $code, wanted $wanted: bsoil $*"
}

# expect_text REGULAR_EXPRESSION: in what bsoil printed last.
expect_text() {
    grep -qE -- "$1" log && return
    cat log
    fail "bsoil did not print '$1'"
}

has_gl() { "$bsoil" info --backend gl >/dev/null 2>&1; }

# use_scene SCENE [VOXEL_M]: into `scene`, with other voxels where they are given.
use_scene() {
    scene=$1
    if [[ -n ${2:-} ]]; then
        sed "s/^voxel_m = .*/voxel_m = $2/" "$1" >scene.toml
        scene=scene.toml
    fi
}

passes() {
    local code=0
    use_scene "$@"
    "$bsoil" run "$scene" --backend cpu --no-pictures --out out || code=$?
    exit "$code"
}

# The first steps of a long scene, in which so many of its checks are reached.
starts_well() {
    expect 0 run "$1" --backend cpu --no-pictures --out out --steps "$2"
    cat log
    (($(grep -c '^PASS' log) >= $3)) || fail "fewer than $3 checks are reached"
}

# units start|end|in|out RUN: the units of every material, one number a line.
units() { sed -n "/\"soil_units_$1\"/,/}/s/.*: \(-\{0,1\}[0-9]*\),\{0,1\}$/\1/p" "$2/summary.json"; }
# What started in RUN, came in and did not go out, likewise.
units_accounted() {
    local start in out
    while read -r start in out; do
        echo $((start + in - out))
    done < <(paste <(units start "$1") <(units in "$1") <(units out "$1"))
}
checksum() { sed -n 's/.*"checksum": "\([0-9a-f]*\)".*/\1/p' "$1/summary.json"; }

# check_run NAME: the soil of the run in the folder NAME is all there at the end.
check_run() {
    local name=$1
    [[ -n $(units start "$name") ]] || fail "$name: the summary names no soil"
    [[ $(units end "$name") == "$(units_accounted "$name")" ]] || fail "$name: soil is lost or made"
    printf '%-14s %s\n' "$name" "$(checksum "$name")"
}

# run_scene NAME ARGUMENTS...: into the folder NAME, and checks it.
run_scene() {
    local name=$1
    shift
    expect 0 run "$scene" --no-pictures --out "$name" "$@"
    check_run "$name"
}

expect_same_bits() {
    [[ $(checksum "$1") =~ ^[0-9a-f]{16}$ ]] || fail "$1: the summary has no checksum"
    [[ $(checksum "$1") == "$(checksum "$2")" ]] || fail "$1 and $2 end in different soil"
}

# positions_um RUN: x, y and z of every body [micrometres], one number a line.
positions_um() {
    grep -A3 '"position_m"' "$1/summary.json" | sed -n 's/^ *\([-+.e0-9]*[0-9]\),\{0,1\}$/\1/p' |
        xargs -r printf '%.6f\n' | sed 's/\.//; s/^\(-\{0,1\}\)0*\([0-9]\)/\1\2/'
}

# The grid is turned against the bodies by a quarter turn when y is up (its x, y, z are then the world's Z, X, Y), and
# Bullet's poses round differently, so the soil's bits may differ and a slip may start one voxel further on. The bodies
# end in the same places, within a tolerance in micrometres.
expect_same_places() {
    local up_tolerance_um=$3
    local -a z_up y_up
    mapfile -t z_up < <(positions_um "$1")
    mapfile -t y_up < <(positions_um "$2")
    ((${#z_up[@]} == ${#y_up[@]})) || fail "$1 and $2 have different bodies"
    local i off
    for ((i = 0; i < ${#z_up[@]}; i += 3)); do # (x, y, z) with z up is (x, z, -y) with y up
        for off in $((z_up[i] - y_up[i])) $((z_up[i + 1] + y_up[i + 2])) $((z_up[i + 2] - y_up[i + 1])); do
            ((${off#-} <= up_tolerance_um)) || fail "body $((i / 3)) of $2 is $off um off $1"
        done
    done
}

same_bits() {
    local steps=$2 gl_steps=$3 up_tolerance_um=$4
    use_scene "$1" "${5:-}"
    run_scene one_step --backend cpu --steps 1
    # On one thread with kernels for any processor, on two with those for this one.
    BULLETSOIL_CPU=baseline run_scene one_thread --backend cpu --steps "$steps" --threads 1
    [[ $(checksum one_step) != "$(checksum one_thread)" ]] || fail "nothing moves in $steps steps"
    run_scene two_threads --backend cpu --steps "$steps" --threads 2 --up z # and the axis named
    expect_same_bits one_thread two_threads
    run_scene y_up --backend cpu --steps "$steps" --up y
    expect_same_places two_threads y_up "$up_tolerance_um"
    # Whether there is OpenGL takes a third of a second to find out: asked where the run fails.
    if ! "$bsoil" run "$scene" --no-pictures --out gl --steps "$gl_steps" --backend gl >log 2>&1; then
        has_gl && cat log && fail "the run with OpenGL"
        printf 'no OpenGL: compared on the CPU only\n'
        return
    fi
    check_run gl
    run_scene cpu --backend cpu --steps "$gl_steps"
    expect_same_bits cpu gl
}

# write_scene [LINE]: a block of sand; LINE goes to the end of [soil], which is line 7 of scene.toml.
write_scene() {
    cat >scene.toml <<END
[world]
duration_s = 0.2

[soil]
size_m = [1.0, 1.0, 0.8]
voxel_m = 0.05
${1:-}

[[fill]]
kind = "box"
min_m = [-0.2, -0.2, 0]
max_m = [0.2, 0.2, 0.4]
END
}

# A run that goes on from a snapshot ends as the run that wrote it, and as one that wrote none: soil, bodies, checks,
# telemetry.
restarts() {
    local scene=$1 steps=$2 at=$3 run file
    run_scene plain --backend cpu --steps "$steps"
    run_scene saving --backend cpu --steps "$steps" --snapshot-every "$at"
    run_scene restored --backend cpu --threads 2 --steps "$steps" --from "$(printf 'saving/step_%06d.snapshot' "$at")"
    for run in saving restored; do
        expect_same_bits plain "$run"
        # All of the summary but the device, and what is a matter of time.
        for file in plain "$run"; do
            grep -vE '"(threads|device|wall_s|steps_per_s|step_ms_[a-z0-9]*|voxelize|deform|advect|slip|contacts|activity|awake_bytes|asleep_bytes|bytes_per_awake_voxel|bytes_per_asleep_column)"' \
                "$file/summary.json" >"$file.summary"
        done
        diff plain.summary "$run.summary" || fail "$run: another summary"
    done
    diff plain/telemetry.csv saving/telemetry.csv || fail "saving: another telemetry"
    sed 1d restored/telemetry.csv >rows
    [[ -s rows ]] || fail "restored: no telemetry"
    tail -n "$(wc -l <rows)" plain/telemetry.csv | diff - rows || fail "restored: another telemetry"

    head -c 5000 saving/final.snapshot >cut.snapshot
    expect 2 run "$scene" --no-pictures --out refused --from cut.snapshot
    expect_text 'cut.snapshot.*damaged or cut short'
    expect 2 run "$scene" --no-pictures --out refused --steps "$at" --from saving/final.snapshot
    expect_text 'where the run ends'
    expect 2 run "$scene" --no-pictures --out refused --up y --from saving/final.snapshot
    expect_text 'final.snapshot'

    # A snapshot knows its scene.
    expect 0 export saving/final.snapshot --out heights.asc
    expect 0 export "$scene" --from saving/final.snapshot --out the_same.asc
    cmp heights.asc the_same.asc || fail "export: another moment"
    expect 2 export cut.snapshot --out refused.asc
    expect_text 'cut.snapshot.*damaged or cut short'
    expect 2 export saving/final.snapshot --from saving/final.snapshot --out refused.asc
    expect_text 'is a snapshot itself'
}

cli_unknown_key() {
    write_scene 'voxl_m = 0.05'
    expect 2 run scene.toml --out out
    expect_text '^scene\.toml:7:1: .*voxl_m'
}

cli_check_exit_codes() {
    write_scene
    local check=(check scene.toml --backend cpu --against baseline.json)
    expect 2 "${check[@]}"
    expect_text '^baseline\.json: not there'
    expect 0 "${check[@]}" --update
    expect 0 "${check[@]}"
    expect_text '^PASS'
    sed -i 's/"checksum": "[0-9a-f]*"/"checksum": "0"/' baseline.json
    expect 1 "${check[@]}"
    expect_text 'end\.checksum: expected'
    expect_text '^FAIL'
    expect 0 "${check[@]}" --tolerance 0.001
}

cli_info() {
    expect 0 info --backend cpu
    local heading
    for heading in devices backend limits materials; do expect_text "^$heading$"; done
}

cli_bad_backend() {
    write_scene
    expect 2 run scene.toml --out out --backend abacus
    expect_text '--backend: abacus'
}

cli_no_gl() {
    write_scene
    export __EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent
    expect 2 run scene.toml --out out --backend gl
    expect_text 'no EGL driver'
    expect 0 run scene.toml --out out # pictures alone are no reason to fail
    expect_text '^no pictures: '
}

cli_frames() {
    has_gl || skip 'no OpenGL'
    write_scene
    expect 0 run scene.toml --out out --backend cpu --steps 4 --frames
    # 4 steps of 1/60 s reach the frames at 0, 1/30 and 2/30 s.
    [[ $(cd out/frames && echo *) == '00000.png 00001.png 00002.png' ]] || fail "frames: $(ls out/frames)"
    local picture
    for picture in out/frames/*.png out/contact_sheet.png; do
        head -c 8 "$picture" | cmp -s - <(printf '\x89PNG\r\n\x1a\n') || fail "$picture is no PNG"
    done
}

# A film is of the run's own frames, by the scene's time. Those that a longer run has left in the folder go.
cli_film() {
    has_gl || skip 'no OpenGL'
    write_scene
    mkdir -p bin out/frames
    install -m 755 /dev/stdin bin/ffmpeg <<<$'#!/bin/sh\necho "$*" >>ffmpeg.log'
    touch out/frames/00003.png
    PATH=$PWD/bin:$PATH
    expect 0 run scene.toml --out out --backend cpu --steps 4 --video
    grep -q -- '-start_number 0 .* -frames:v 3 ' ffmpeg.log || fail "film: $(cat ffmpeg.log)"
    grep -q -- '-nostdin' ffmpeg.log || fail 'ffmpeg reads what is not its own'
    # Frames go on where the snapshot is; at step 4 that of 2/30 s is due. 8 steps more reach 6/30 s.
    expect 0 run scene.toml --out rest --backend cpu --from out/final.snapshot --video
    grep -q -- '-start_number 2 .* -frames:v 5 ' ffmpeg.log || fail "film: $(cat ffmpeg.log)"
    [[ ! -e out/frames/00003.png ]] || fail 'a frame of a longer run is left'
    [[ $(cd rest/frames && echo *) == '00002.png 00003.png 00004.png 00005.png 00006.png' ]] ||
        fail "frames: $(ls rest/frames)"
    # Steps of 1/20 s: each is a frame and a half.
    sed -i 's/^voxel_m.*/&\nstep_s = 0.05/' scene.toml
    expect 0 run scene.toml --out long --backend cpu --steps 2 --video
    tail -n 1 ffmpeg.log | grep -q -- '-start_number 0 .* -frames:v 4 ' || fail "film: $(cat ffmpeg.log)"
}

# Moments of a run with its other axis up, whose scene has gone elsewhere; and what they are asked for.
cli_moment() {
    write_scene
    expect 0 run scene.toml --out out --backend cpu --no-pictures --steps 2 --up y
    mv scene.toml moved.toml
    expect 2 export out/final.snapshot --out lost.asc
    expect_text 'say where it is now'
    expect 0 export moved.toml --from out/final.snapshot --backend cpu --out heights.asc
    expect 2 export moved.toml --backend cpu --out no/such/folder/a.asc --out second.asc
    expect_text '^no/such/folder/a.asc: cannot be written'
    [[ -s second.asc ]] || fail 'a file that cannot be written costs the others'
    expect 2 export moved.toml --advance -1 --out heights.asc
    expect_text '-1 is too small, must be 0 or more'
    expect 2 render moved.toml --out no.png --width 0
    expect_text '--width'
    expect 2 render moved.toml --advance 1000000
    expect_text 'say what to write'
    expect 2 render moved.toml --backend cpu --out no.png --volume moisture
    expect_text 'this soil has no moisture'
}

cli_empty_scene() {
    : >scene.toml
    expect 2 run scene.toml --out out
    expect_text '^scene\.toml.*a scene needs \[world\]: '
}

cli_mistyped_words() {
    write_scene
    expect 2 rum scene.toml --out out
    expect_text '^unknown command `rum`; did you mean `run`\?$'
    expect 2 run scene.toml --ot out
    expect_text '^bsoil run: unknown option `--ot`; did you mean `--out`\?$'
    expect 2 --verison
    expect_text '^bsoil: unknown option `--verison`; did you mean `--version`\?$'
    expect 2 xyzzy
    expect_text '^unknown command `xyzzy`; see bsoil --help$'
}

cli_steps_zero() {
    write_scene
    expect 2 run scene.toml --out out --steps 0
    expect_text '^--steps: 0 is too small, must be 1 or more$'
}

# Before the run, and not after it.
cli_no_ffmpeg() {
    write_scene
    local without=$PWD/empty
    mkdir empty
    PATH=$without "$bsoil" run scene.toml --out out --video >log 2>&1
    [[ $? == 2 ]] || fail 'a film without ffmpeg is not refused'
    expect_text '^--video needs ffmpeg, .*--frames'
    [[ ! -e out ]] || fail 'the run began'
    # An ffmpeg that fails costs the film alone.
    has_gl || return 0
    printf '#!/bin/sh\nexit 1\n' >empty/ffmpeg
    chmod +x empty/ffmpeg
    PATH=$without:$PATH "$bsoil" run scene.toml --out out --backend cpu --video --steps 2 >log 2>&1
    [[ $? == 2 ]] || fail 'a film that failed is not reported'
    expect_text 'video\.mp4: ffmpeg failed'
    local file
    for file in summary.json telemetry.csv final.snapshot contact_sheet.png frames/00000.png; do
        [[ -s out/$file ]] || fail "no $file"
    done
}

# All files of a run's names are of this run; what others have put into its folder stays.
cli_older_run() {
    local file older=(profiles.csv contact_sheet.png video.mp4 step_000120.snapshot frames/00007.png)
    local others=(notes.txt step_1.snapshot profiles.csv.bak frames/mine.png final.snapshot.d/summary.json)
    write_scene
    mkdir -p out/frames out/final.snapshot.d
    for file in "${older[@]}" "${others[@]}"; do touch "out/$file"; done
    expect 0 run scene.toml --out out --backend cpu --no-pictures --steps 4
    for file in "${older[@]}"; do [[ ! -e out/$file ]] || fail "$file is of an older run"; done
    for file in "${others[@]}" summary.json telemetry.csv final.snapshot; do
        [[ -e out/$file ]] || fail "$file is gone"
    done
    # A run that goes on keeps the frames and snapshots of what lies behind it.
    touch out/profiles.csv out/step_000002.snapshot out/frames/00000.png
    expect 0 run scene.toml --out out --backend cpu --no-pictures --from out/final.snapshot
    [[ ! -e out/profiles.csv ]] || fail 'profiles.csv is of an older run'
    for file in step_000002.snapshot frames/00000.png final.snapshot; do
        [[ -e out/$file ]] || fail "$file is gone"
    done
}

cli_interrupted() {
    write_scene
    sed -i 's/duration_s = .*/duration_s = 36000/' scene.toml
    printf '[record]\nmoments_s = [0, 36000]\n' >>scene.toml
    "$bsoil" run scene.toml --backend cpu --out out >log 2>&1 &
    local process=$! code=0 there=out/telemetry.csv
    if has_gl; then there=out/contact_sheet.png; fi # of its first moment, written at once
    for ((i = 0; i < 300; ++i)); do # until it steps
        [[ -s $there ]] && break
        sleep 0.1
    done
    [[ -s $there ]] || fail "no $there while it runs"
    kill -INT "$process"
    wait "$process" || code=$?
    [[ $code == 130 ]] || fail "exit code $code, wanted 130"
    expect_text '^interrupted at step [0-9]+; what there is is written to out$'
    grep -q '"interrupted": true' out/summary.json || fail 'the summary does not say so'
    [[ -s out/final.snapshot ]] || fail 'no snapshot'
}

# What does not fit on the disk is named, and the rest is written.
cli_full_disk() {
    write_scene
    local file
    for file in telemetry.csv summary.json; do
        rm -rf out && mkdir out
        ln -s /dev/full "out/$file"
        expect 2 run scene.toml --out out --no-pictures
        expect_text "^out/$file: cannot be written whole"
        [[ -s out/final.snapshot ]] || fail "$file: no snapshot"
    done
    has_gl || return 0
    rm -rf out && mkdir out
    ln -s /dev/full out/contact_sheet.png
    expect 2 run scene.toml --backend cpu --out out --steps 2
    expect_text '^out/contact_sheet\.png: cannot be written whole'
    [[ -s out/summary.json ]] || fail 'no summary'
}

# A soil of 16 million columns takes more than the 200 MB that the process may have.
cli_out_of_memory() {
    (ulimit -v 200000 && "$bsoil" --version >/dev/null 2>&1) || skip 'this build needs more from its start'
    cat >scene.toml <<'END'
fill = [{ kind = "noise", base_m = 3 }]
world = { duration_s = 0.1 }
[soil]
size_m = [200, 200, 10]
voxel_m = 0.05
END
    ulimit -v 200000
    expect 2 run scene.toml --backend cpu --threads 1 --no-pictures --out out
    expect_text '^bsoil: the memory of this machine is full; lower `size_m`|cannot allocate .*; take a smaller grid or larger voxels'
}

# write_ball X LINE: a ball over the block of sand, at x.
write_ball() {
    write_scene
    cat >>scene.toml <<END

[[body]]
name = "ball"
shape = "sphere"
radius_m = 0.1
mass_kg = 1
position_m = [$1, 0, 0.6]
$2
END
}

cli_starts_outside() {
    write_ball 5 ''
    expect 0 run scene.toml --out out --no-pictures
    expect_text '^scene\.toml:14:1: body `ball` starts outside the soil.s box'
    write_ball 0 ''
    expect 0 run scene.toml --out out --no-pictures
    ! grep -q 'starts outside' log || fail 'a body inside is said to start outside'
}

# Which body, where and when, once.
cli_conditions() {
    write_ball 0 'velocity_m_s = [5, 0, 0]'
    expect 0 run scene.toml --out out --no-pictures
    expect_text '^body_outside_grid: .* \[body ball, at \(0\.[0-9]+, 0\.00, 0\.[0-9]+\) m, step [0-9]+, 0\.[0-9]+ s\]$'
    (($(grep -c body_outside_grid log) == 1)) || fail 'more than once'
    grep -A4 '"name": "body_outside_grid"' out/summary.json | grep -q '"body": "ball"' || fail 'not in the summary'
}

cli_software_gl() {
    has_gl || skip 'no OpenGL'
    "$bsoil" info | grep -q '^  + .*(software)' || skip 'no software OpenGL'
    ! "$bsoil" info | grep '^  + ' | sed 1d | grep -qv '(software)' || skip 'a GPU is there' # the first is the CPU
    write_scene
    expect 0 run scene.toml --out out --no-pictures --backend gl --steps 1
    expect_text '^no GPU here: OpenGL runs in software .*--backend cpu'
}

# The same figures in a file and on a page; the checksum is that of a run.
cli_bench() {
    write_scene
    expect 0 run scene.toml --out out --no-pictures --steps 3
    local checksum
    checksum=$(sed -n 's/.*"checksum": *"\([0-9a-f]*\)".*/\1/p' out/summary.json)
    expect 0 bench --no-thesis --steps 3 --scene scene.toml --out bench.json --page bench.md
    grep -q "\"checksum\": \"$checksum\"" bench.json || fail "bench.json lacks the checksum $checksum"
    grep -q "^3 steps, .* Checksum $checksum\.\$" bench.md || fail "bench.md lacks the checksum $checksum"
    grep -q '^| apply_force | 1.0 |' bench.md || fail 'bench.md lacks the passes'
    # A scene that is not there costs the others nothing, nor an older file where there is no other.
    rm bench.json bench.md
    expect 2 bench --no-thesis --no-counts --steps 3 --scene absent.toml --scene scene.toml --out bench.json --page bench.md
    expect_text '^absent.toml: '
    grep -q "\"checksum\": \"$checksum\"" bench.json || fail "absent.toml: bench.json lacks the checksum $checksum"
    grep -q "^3 steps, .* Checksum $checksum\.\$" bench.md || fail 'absent.toml: bench.md lacks the other scene'
    cp bench.json first.json
    expect 2 bench --no-thesis --scene absent.toml --out bench.json
    cmp bench.json first.json || fail 'bench.json is written without figures'
    printf '\n[[robot]]\nname = "r"\nfile = "data:no/such.urdf"\n' | cat scene.toml - >lacks_data.toml
    expect 0 bench --no-thesis --no-counts --steps 3 --scene lacks_data.toml --scene scene.toml --out bench.json
    expect_text '^SKIP lacks_data.toml'
    expect 77 bench --no-thesis --scene lacks_data.toml --out bench.json
    expect 2 bench --no-thesis --page no/such/folder/bench.md
    expect_text '^no/such/folder/bench.md: cannot be written'
    echo '<!-- bsoil bench: other --><!-- end -->' >page.md
    expect 2 bench --no-thesis --scene scene.toml --document page.md
    expect_text '^page.md: .*<!-- bsoil bench: scene -->'
    if ! "$bsoil" info | grep '^  + ' | sed 1d | grep -qv '(software)'; then
        expect 2 bench --gpu
        expect_text '^--gpu: no hardware OpenGL'
    fi
}

"$test_case" "$@"
