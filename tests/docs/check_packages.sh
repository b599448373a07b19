#!/usr/bin/env bash
# Checks that every library package that the scripts install has its note in third_party_notes/.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/demos/setup.sh"
failed=0
for package in "${build_packages[@]}" "${viewer_packages[@]}" "${test_packages[@]}" "${fuzz_packages[@]}"; do
    case $package in build-essential | cmake | pkg-config) continue ;; esac # tools, not dependencies
    grep -rqF "\`$package\`" "$root/third_party_notes" && continue
    printf '%s: no page of third_party_notes names it\n' "$package"
    failed=1
done
exit "$failed"
