#!/usr/bin/env bash
# Digs for a million steps, twice (some half an hour): tests/soak.sh [STEPS]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../demos/setup.sh"

install_packages "${build_packages[@]}" "${test_packages[@]}"
configure "$project_root/build" BULLETSOIL_TESTS=ON CMAKE_BUILD_TYPE?=Release
build "$project_root/build" test_soil
BULLETSOIL_SOAK_STEPS=${1:-1000000} exec "$project_root/build/tests/soil/test_soil" --gtest_filter='Soak.*'
