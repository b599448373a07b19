#!/usr/bin/env bash
# Builds everything and runs the tests: tests/run.sh [--sanitize LIST] [--werror] [--unity] [--gpu] [ARGUMENT OF ctest...]
#   --sanitize LIST  address,undefined or thread; builds in a folder of its own
#   --werror         treats warnings as errors
#   --unity          several sources at once although there is ccache: for a build that finds nothing in the cache
#   --gpu            runs tests/gpu/run.sh instead: the tests that need a hardware GPU; what follows is passed on
# CTEST_PARALLEL_LEVEL tests run at once, 2 where it is not set. The cases of a suite are one test, and run in one process.
# Configured with -DBULLETSOIL_TESTS_BY_SUITE=OFF, a folder keeps a test for each.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../demos/setup.sh"

folder=$project_root/build
options=(CMAKE_BUILD_TYPE?=Release)
while (($#)); do
    case $1 in
        --sanitize)
            list=${2:?--sanitize needs a list: address,undefined or thread}
            folder=$project_root/build-${list//,/-}
            options=(CMAKE_BUILD_TYPE?=RelWithDebInfo "BULLETSOIL_SANITIZE=$list" "${options[@]:1}")
            shift 2
            ;;
        --werror)
            options+=(BULLETSOIL_WERROR=ON)
            shift
            ;;
        --unity)
            options+=(BULLETSOIL_UNITY=ON)
            shift
            ;;
        --gpu)
            shift
            exec "$project_root/tests/gpu/run.sh" "$@"
            ;;
        *) break ;;
    esac
done

install_packages "${build_packages[@]}" "${viewer_packages[@]}" "${export_packages[@]}" "${test_packages[@]}"
configure "$folder" BULLETSOIL_TESTS=ON BULLETSOIL_TESTS_BY_SUITE?=ON "${options[@]}"
build "$folder"
exec ctest --test-dir "$folder" --output-on-failure --no-tests=error -j "${CTEST_PARALLEL_LEVEL:-2}" "$@"
