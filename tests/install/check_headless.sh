#!/usr/bin/env bash
# Holds that a headless build needs no window's libraries: configures without the renderer where pkg-config knows neither SDL,
# Dear ImGui nor libEGL, and looks through what would be compiled and linked. Compiles nothing.
#
#   check_headless.sh SOURCES SCRATCH [CMAKE ARGUMENT...]
set -uo pipefail
sources=$1 scratch=$2
shift 2
rm -rf "$scratch"
mkdir -p "$scratch"
real=$(command -v pkg-config) || { echo "no pkg-config"; exit 1; }
cat >"$scratch/pkg-config" <<EOF
#!/bin/sh
for word; do case \$word in sdl2* | imgui* | egl*) exit 1 ;; esac; done
exec "$real" "\$@"
EOF
chmod +x "$scratch/pkg-config"

configure() {
    PKG_CONFIG=$scratch/pkg-config cmake -S "$sources" -B "$scratch/$1" -G Ninja -DBULLETSOIL_TESTS=OFF "${@:2}" \
        >"$scratch/$1.log" 2>&1
}
# The check can fail: with its renderer the project asks for what is not there.
if configure with_renderer "$@"; then
    echo "FAIL a build with the renderer was configured without EGL: this check sees nothing"
    exit 1
fi
if ! configure headless -DBULLETSOIL_RENDER=OFF "$@"; then
    cat "$scratch/headless.log"
    echo "FAIL the headless build was not configured"
    exit 1
fi
found=$(grep -rEil 'libSDL|SDL2|imgui|plugin/render|demos/viewer/view' \
    "$scratch/headless/compile_commands.json" "$scratch/headless/build.ninja")
[[ -z $found ]] || { echo "FAIL names a window's libraries: $found"; exit 1; }
grep -q 'no_view\.cpp' "$scratch/headless/compile_commands.json" || { echo "FAIL bsoil is not built"; exit 1; }
