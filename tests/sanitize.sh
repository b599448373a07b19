#!/usr/bin/env bash
# Builds the libraries, the command and their tests with a sanitizer and runs them:
# tests/sanitize.sh thread|address [ARGUMENT OF ctest...]
#   thread   data races between the CPU backend's threads, and between worlds in threads of their own
#   address  memory errors, leaks and undefined behaviour
# Left out are the tests whose time says nothing about either (a sanitizer makes them 5 to 20 times slower) and, with
# `thread`, those of software GL: its driver's threads are not built for the sanitizer.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../demos/setup.sh"

kind=${1:-}
shift || true
# Of whole scenes those run that stop and go on from a snapshot: the reader of scenes, the bridge and the soil together.
left_out='ManyBodies|Stability|Repose|Allocation|^scene\..*\.(passes.*|first_cut|same_bits)$|^demo[._](fork_lift|multibody_robot|raycast_vehicle)$'
left_out+='|^experiment\.(plate_unload|second_pass)$'
labels='device|soil|mesh|bridge|c_api|scenes|experiments'
targets=(test_device test_soil test_mesh test_bridge test_c_api_bullet test_scenes test_experiments bsoil)
case $kind in
    thread)
        list=thread
        render=OFF
        left_out+='|[Gg]l[A-Z_]|_on_gl|no_gl|^demo\.(hello_soil|world_from_file)$|test_c_api_bullet_double'
        # history_size: older accesses keep their stacks, which the suppressions look at.
        export TSAN_OPTIONS="allocator_may_return_null=1:history_size=7:suppressions=$project_root/tests/device/thread_sanitizer.supp"
        ;;
    address)
        list=address,undefined
        render=ON
        export ASAN_OPTIONS=allocator_may_return_null=1  # tests ask for more than there is
        left_out+='|^UrdfErrors\.loop_without_a_root' # urdfdom itself never frees such links
        labels+='|fuzz'
        targets+=(fuzz_replay test_c_api_bullet_double hello_soil world_from_file)
        ;;
    *)
        say "usage: tests/sanitize.sh thread|address [ARGUMENT OF ctest...]"
        exit 2
        ;;
esac

install_packages "${build_packages[@]}" "${test_packages[@]}"
folder=$project_root/build-${list//,/-}-libraries
configure "$folder" BULLETSOIL_TESTS=ON "BULLETSOIL_RENDER=$render" "BULLETSOIL_SANITIZE=$list" \
    CMAKE_BUILD_TYPE?=RelWithDebInfo "CMAKE_CXX_FLAGS_RELWITHDEBINFO?=-O1 -g1" # lines are all that reports need
build "$folder" "${targets[@]}"
exec ctest --test-dir "$folder" --output-on-failure --no-tests=error -j "${CTEST_PARALLEL_LEVEL:-2}" \
    -L "$labels" -E "$left_out" --timeout 1200 "$@"
