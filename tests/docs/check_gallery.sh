#!/usr/bin/env bash
# Checks that docs/gallery.md has every scene, or says why not, and nothing that is not there.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"
page=docs/gallery.md
for scene in demos/scenes/*.toml; do
    name=$(basename "$scene" .toml)
    grep -qE "\`(demos/run.sh )?$name\`" "$page" || fail "$page says nothing of scene $name: add it to demos/gallery.sh"
done
while read -r name; do
    [[ -f demos/scenes/$name.toml ]] || fail "$page has a scene $name, which is not there"
done < <(grep -oE '`demos/run.sh [a-z0-9_]+`' "$page" | sed -E 's/.* ([a-z0-9_]+)`/\1/')
for picture in docs/images/gallery/*.jpg; do
    grep -q "images/gallery/$(basename "$picture")" "$page" || fail "$page does not show $picture"
done
exit "$failed"
