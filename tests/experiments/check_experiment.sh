#!/usr/bin/env bash
# Checks the commands of experiments from outside: check_experiment.sh BSOIL FOLDER CASE
set -euo pipefail
bsoil=$1 folder=$2 case=$3
experiments=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../demos/experiments" && pwd)
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"

fail() {
    printf 'FAIL: %s\n' "$*"
    exit 1
}
# expect_exit CODE COMMAND...: runs it, output in output.txt
expect_exit() {
    local expected=$1 code=0
    shift
    "$@" >output.txt 2>&1 || code=$?
    cat output.txt
    [[ $code == "$expected" ]] || fail "exit code $code, not $expected, of: $*"
}
little_memory() (
    ulimit -v 200000
    "$@"
)
expect_text() { grep -qF -- "$1" output.txt || fail "the output lacks: $1"; }

cat >plate.toml <<'END'
title = "A plate in the air"
[plate]
reach_m = [0.01, 0.02]
[sweep]
radius_m = [0.03, 0.05]
[measured]
file = "measured.csv"
column = [{ name = "radius_m", column = "d_mm", factor = 0.0005 }, { name = "sinkage_m", column = "z_m" },
          { name = "force_n", column = "F_N" }]
[[expect]]
column = "force_n"
max = 0.1
min = -0.1
END
printf 'd_mm,z_m,F_N\n60,0.01,5\n60,0.01,7\n100,0.02,9\n' >measured.csv

case $case in
    results)
        mkdir out
        touch out/series_007.csv out/mine.csv # of a longer sweep, and of somebody else
        expect_exit 0 "$bsoil" plate plate.toml --out out --series
        expect_text 'PASS force_n: expected at least -0.1 at most 0.1'
        expect_text 'point 1 radius_m=0.05' # progress, as lines
        head -n 1 out/results.csv | grep -qx \
            'point,radius_m,sinkage_m,force_n,pressure_pa,force_n_measured,force_n_error' || fail 'headings of results.csv'
        [[ ! -e out/series_007.csv && -e out/mine.csv ]] || fail "leftovers: $(ls out)"
        (($(wc -l <out/results.csv) == 5)) || fail 'results.csv has not four rows'
        grep -q '^0,0.03,0.01,.*,6,-1' out/results.csv || fail 'no measured mean of 6 N'
        head -n 1 out/series_001.csv | grep -qx 'time_s,sinkage_m,force_n,pressure_pa' || fail 'headings of the series'
        command -v gnuplot >/dev/null || { echo 'SKIP: gnuplot is not there' && exit 77; }
        head -c 8 out/results.png | grep -q PNG || fail 'results.png is no PNG'
        grep -q '</svg>' out/results.svg || fail 'results.svg is no whole SVG'
        ;;
    exit_codes)
        expect_exit 1 "$bsoil" plate plate.toml --out out --no-plot --set expect.min=0.05
        expect_text 'FAIL force_n'
        expect_exit 2 "$bsoil" blade plate.toml --out out
        expect_text 'bsoil plate'
        expect_exit 2 "$bsoil" plate plate.toml --out out --set radius=1
        expect_text 'plate.toml: wrong unit in `radius`: the key is `radius_m`'
        expect_exit 2 "$bsoil" plate nowhere.toml --out out
        expect_exit 2 "$bsoil" plate plate.toml
        export BULLETSOIL_DATA=$folder/nowhere
        expect_exit 77 "$bsoil" traction "$experiments/pavlov_wheel_smooth.toml" --out out
        expect_text 'cmu_pavlov2022_wheel_means.csv is not there'
        sed 's/file = .*/file = "data:absent.csv"/' plate.toml >absent.toml
        expect_exit 0 "$bsoil" plate absent.toml --out out --no-plot
        expect_text 'no measured values'
        ;;
    no_gnuplot)
        mkdir bin
        ln -s "$(command -v sh)" bin/sh
        expect_exit 0 env PATH="$folder/bin" "$bsoil" plate plate.toml --out out
        expect_text 'gnuplot is not installed'
        [[ -s out/results.csv && -s out/results.gnuplot ]] || fail 'the table or the script is missing'
        ;;
    validate)
        mkdir own
        cat >own/plate.toml <<'END'
title = "A plate above its soil"
[soil]
size_m = [0.4, 0.4, 0.2]
voxel_m = 0.02
[bed]
depth_m = 0.1
[plate]
reach_m = [0.01, 0.02]
speed_m_s = 0.05
[measured]
file = "data:plates.csv"
column = [{ name = "sinkage_m", column = "z_m" }, { name = "pressure_pa", column = "p_pa" }]
[[plot]]
x = "sinkage_m"
y = "pressure_pa"
[[expect]]
title = "it bears"
column = "pressure_pa"
min = 1
[validation]
classical = "bekker"
[[validation.compare]]
column = "pressure_pa"
END
        printf 'z_m,p_pa\n0.01,1000\n0.02,2500\n' >plates.csv
        printf '# By hand\n<!-- bsoil validate: summary -->\n<!-- end -->\n<!-- bsoil validate: plate -->\n<!-- end -->\n' >page.md
        export BULLETSOIL_DATA=$folder
        expect_exit 0 "$bsoil" validate --experiments own --out out --document page.md
        expect_text 'PASS it bears'
        cp page.md first.md
        cp page/plate.svg first.svg
        expect_exit 0 "$bsoil" validate --experiments own --only plate --document page.md --threads 1
        cmp page.md first.md || fail 'a second run changes the page'
        cmp page/plate.svg first.svg || fail 'a second run changes the picture'
        grep -qx '# By hand' page.md || fail 'the prose is gone'
        grep -q 'A plate above its soil' page.md || fail 'the page lacks the experiment'
        head -n 1 out/plate.csv | grep -q 'pressure_pa_classical_error' || fail 'headings of plate.csv'
        sed -i 's/^min = 1$/min = 1e9/' own/plate.toml
        expect_exit 1 "$bsoil" validate --experiments own
        expect_text 'FAIL it bears'
        expect_exit 2 "$bsoil" validate --experiments own --only absent
        expect_exit 2 "$bsoil" validate --experiments own --document absent.md
        export BULLETSOIL_DATA=$folder/nowhere
        expect_exit 77 "$bsoil" validate --experiments own
        expect_text 'plates.csv is not there'
        # A point that cannot be run costs its own experiment alone, and the page nothing.
        export BULLETSOIL_DATA=$folder
        sed 's/^size_m = .*/size_m = [150, 150, 0.2]/' own/plate.toml >own/stuck.toml
        printf '<!-- bsoil validate: stuck -->\n<!-- end -->\n' >>page.md
        cp page.md first.md
        little_memory "$bsoil" --version >/dev/null 2>&1 || exit 0 # needs more from its start
        expect_exit 2 little_memory "$bsoil" validate --experiments own --threads 1 --out rest --document page.md
        expect_text 'stuck.toml: point 0: '
        expect_text 'page.md: stays as it was'
        expect_text 'FAIL it bears'
        cmp page.md first.md || fail 'a run that lacks an experiment changes the page'
        [[ -s rest/plate.csv && ! -e rest/stuck.csv ]] || fail 'files of a run that lacks an experiment'
        ;;
    keys)
        "$bsoil" experiment-keys --markdown | diff - "$experiments/README.md" ||
            fail 'demos/experiments/README.md is not what `bsoil experiment-keys --markdown` prints'
        ;;
    *) fail "no case $case" ;;
esac
