#!/usr/bin/env bash
# Checks that the rooms of demos/src include one another one way only: each the rooms before it, none after it. Host programs
# show what a host needs: only what reads robots and worlds from files, nothing of scenes.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"
cd demos/src || exit 1
rooms=(scene files robots reading world run experiment commands)

# check ROOM ALLOWED...: what the room's files include of other rooms is allowed.
check() {
    local room=$1 file included
    shift
    while IFS=: read -r file included; do
        [[ " $room $* " == *" ${included%%/*} "* ]] || fail "demos/src/$file includes $included"
    done < <(grep -oE '^#include "[a-z_]+/[^"]+"' "$room"/*.{h,cpp} 2>/dev/null | sed -E 's/#include "(.*)"/\1/' |
        grep -v ':bsoil/')
}

for ((i = 0; i < ${#rooms[@]}; ++i)); do
    [[ -d ${rooms[i]} ]] || fail "there is no room demos/src/${rooms[i]}"
    check "${rooms[@]:i:1}" "${rooms[@]:0:i}"
done
check hosts robots
for entry in *; do
    [[ " ${rooms[*]} hosts README.md " == *" $entry "* ]] || fail "demos/src/$entry belongs into a room"
done
exit "$failed"
