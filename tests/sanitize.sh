#!/usr/bin/env bash
# Builds the soil, the bridge and their tests with a sanitizer and runs them:
# tests/sanitize.sh thread|address [ARGUMENT OF ctest...]
#   thread   data races between the CPU backend's threads, and between worlds in threads of their own
#   address  memory errors, leaks and undefined behaviour
# Left out are the tests whose time says nothing about either (a sanitizer makes them 5 to 20 times slower) and, with
# `thread`, those of software GL: its driver's threads are not built for the sanitizer.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../demos/setup.sh"

kind=${1:-}
shift || true
slow='ManyBodies|Stability|Bekker|Repose|Scenarios'
case $kind in
    thread)
        list=thread
        slow+='|[Gg]l[A-Z_]|gl_context|Allocation'
        # history_size: older accesses keep their stacks, which the suppressions look at.
        export TSAN_OPTIONS="history_size=7:suppressions=$project_root/tests/device/thread_sanitizer.supp"
        ;;
    address)
        list=address,undefined
        slow+='|Allocation'
        ;;
    *)
        say "usage: tests/sanitize.sh thread|address [ARGUMENT OF ctest...]"
        exit 2
        ;;
esac

install_packages "${build_packages[@]}" "${test_packages[@]}"
folder=$project_root/build-${list//,/-}-libraries
configure "$folder" BULLETSOIL_TESTS=ON BULLETSOIL_DEMOS=OFF BULLETSOIL_RENDER=OFF "BULLETSOIL_SANITIZE=$list" \
    CMAKE_BUILD_TYPE?=RelWithDebInfo
cmake --build "$folder" --target test_device test_soil test_bridge
exec ctest --test-dir "$folder" --output-on-failure --no-tests=error -j "${CTEST_PARALLEL_LEVEL:-2}" \
    -L 'device|soil|bridge' -E "$slow" --timeout 1200 "$@"
