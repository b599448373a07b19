#!/usr/bin/env bash
# Checks that the patches of docs/adding_a_property.md, and then those of docs/adding_a_pass.md, apply to the sources: check_patches.sh
# FOLDER, where a copy goes. What they make is built and run by check_property.sh and check_pass.sh, which take longer.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
sources=${1:?a folder to work in}
rm -rf "$sources"
mkdir -p "$sources"
cp -rp "$root"/{CMakeLists.txt,plugin,shaders,bridge,demos,docs,tests} "$sources"
for page in property pass; do
    sed -n '/^```diff$/,/^```$/{/^```/d;p}' "$root/docs/adding_a_$page.md" | git -C "$sources" apply -p1 || {
        printf 'the patches of docs/adding_a_%s.md do not apply\n' "$page" >&2
        exit 1
    }
done
rm -rf "$sources"
