#!/usr/bin/env bash
# Builds `bsoil` and runs a scene: demos/run.sh [SCENE] [OPTION OF bsoil run...]
# SCENE is a name out of demos/scenes/ (excavator where none is given) or a path to a scene file.
# Exit code: that of `bsoil run`; 0 all of the scene's checks passed, 1 one failed, 2 could not run, 77 data is missing.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

scene=excavator
if [[ $# -gt 0 && $1 != -* ]]; then
    scene=$1
    shift
fi
scene_file=$project_root/demos/scenes/$scene.toml
if [[ $scene == *.toml ]]; then
    scene_file=$scene
    scene=$(basename "$scene" .toml)
fi
if [[ ! -f $scene_file ]]; then
    say "$scene_file is not there; demos/scenes has:"
    for known in "$project_root"/demos/scenes/*.toml; do say "    $(basename "$known" .toml)"; done
    exit 2
fi

install_packages "${build_packages[@]}" || exit 2
install_packages "${viewer_packages[@]}" || say "bsoil view is left out"
install_packages "${export_packages[@]}" || say "GeoTIFFs are left out"
configure "$project_root/build" CMAKE_BUILD_TYPE?=Release BULLETSOIL_TESTS?=OFF BULLETSOIL_UNITY?=ON || exit 2
build "$project_root/build" bsoil || exit 2

out=$project_root/out/$scene
result=0
"$project_root/build/demos/bsoil" run "$scene_file" --out "$out" "$@" || result=$?

describe() {
    if [[ -f $out/$1 ]]; then say "$(printf '%-9s' "$2") $out/$1"; fi
}
if ((result < 2)); then
    describe contact_sheet.png picture
    describe summary.json summary
    describe telemetry.csv numbers
fi
exit "$result"
