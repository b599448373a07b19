#!/usr/bin/env bash
# Checks that every library package that the scripts install has its note in third_party_notes/.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"
source demos/setup.sh
for package in "${build_packages[@]}" "${viewer_packages[@]}" "${export_packages[@]}" "${test_packages[@]}" "${fuzz_packages[@]}"; do
    case $package in build-essential | cmake | pkg-config) continue ;; esac # tools, not dependencies
    grep -rqF "\`$package\`" third_party_notes || fail "$package: no page of third_party_notes names it"
done
exit "$failed"
