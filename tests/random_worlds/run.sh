#!/usr/bin/env bash
# Random worlds by the thousand: tests/random_worlds/run.sh [--sanitize] [ARGUMENT OF random_worlds...]
#   --sanitize           with the address and undefined-behaviour sanitizers
#   --seeds A..B         which worlds; 1..1000
#   --minutes M          no longer than that; Ctrl-C ends it after the world at hand
#   --steps N            until so many steps are done
#   --seed N --run watched|repeated|restored|gl|drawn --kind any|calm|small
#                        one world alone, as the line "replay:" of a failure says
#   --describe           prints what is in it
#   --minimize           drops what the failure does not need
#   --all                known faults as well
#   --weather, --dry     only worlds with water, wind and all else of add_weather.h, or only those without
# Fails where a promise is not kept.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../../demos/setup.sh"

folder=$project_root/build
options=(CMAKE_BUILD_TYPE?=Release)
if [[ ${1:-} == --sanitize ]]; then
    shift
    folder=$project_root/build-random-worlds-sanitized
    options=(CMAKE_BUILD_TYPE?=RelWithDebInfo BULLETSOIL_SANITIZE=address,undefined BULLETSOIL_DEMOS=OFF
        BULLETSOIL_RENDER=OFF "CMAKE_CXX_FLAGS_RELWITHDEBINFO?=-O1 -g1")
fi
install_packages "${build_packages[@]}" "${test_packages[@]}"
configure "$folder" BULLETSOIL_TESTS=ON "${options[@]}"
build "$folder" random_worlds
exec "$folder/tests/random_worlds/random_worlds" "$@"
