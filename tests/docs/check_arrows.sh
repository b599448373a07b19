#!/usr/bin/env bash
# Checks that includes run one way only. Between folders: demos, tests -> bridge -> plugin -> shaders, and within plugin/src
# host -> soil -> contact -> base -> device: no file of one of these rooms includes a room before it. Within bridge/ no file
# includes one that needs it: a topological order of its headers and sources exists, and none but the top ones includes the top
# class (bsoil/bullet/soil_action.h). Prints each arrow that runs back up.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"

# not_in FOLDER PATTERN WHY: no file of the folder includes what matches.
not_in() {
    local found
    found=$(grep -rnE "^#include [\"<]$2" "$1" --include='*.h' --include='*.cpp' --include='*.glsl')
    [[ -z $found ]] || fail "$3:"$'\n'"$found"
}
not_in plugin '(bsoil/bullet|bsoil/c/|bt[A-Z]|Bullet|LinearMath)' "the plugin knows no Bullet"
not_in plugin/src/device '(soil/|contact/|mesh/|bsoil/(soil|body|material|contact|render))' "the device layer knows no soil"
not_in plugin/src/base '(soil/|contact/|mesh/|host/|bsoil/(host|render))' "what all rooms stand on knows none of them"
not_in plugin/src/contact '(soil/|mesh/|host/|bsoil/(soil\.h|host|render))' "the contact wing knows no soil, no tiles and no step"
not_in plugin/include/bsoil/contact 'bsoil/(soil\.h|host|render)' "the contact wing knows no soil"
not_in plugin/src/soil '(mesh/|host/|bsoil/host)' "the soil knows no host"
not_in plugin/src/host '(soil/|contact/|device/|base/|mesh/)' "a host sees public headers alone"
not_in plugin/src/soil '(epoxy|EGL|GL)/' "the soil layer knows no GL"
not_in bridge '(scene|files|robots|reading|world|run|experiment|commands)/' "the bridge knows no demos"

# Who may know the top class: itself, what is built on it, and its own snapshot.
top='bsoil/bullet/soil_action.h'
may_know=(bridge/include/bsoil/bullet/{soil_raycaster,world_snapshot}.h
    bridge/src/{soil_action,world_snapshot,world_state,soil_raycaster}.cpp bridge/src/{c_calls,world_state,soil_action}.h)
while IFS= read -r file; do
    [[ " ${may_know[*]} " == *" $file "* ]] || fail "$file includes the top class"
done < <(grep -rlE "^#include \"$top\"" bridge)

# Arrows file -> header within the bridge; a header and its source count as one room.
arrows=$(grep -rnoE '^#include "[^"]+"' bridge/src bridge/include --include='*.h' --include='*.cpp' |
    sed -E 's/^([^:]+):[0-9]+:#include "([^"]+)"$/\1 \2/' | awk '
        function room(file) {
            if (match(file, /[a-z_]+\.(h|cpp)$/) && (RSTART == 1 || substr(file, RSTART - 1, 1) == "/")) {
                file = substr(file, RSTART)
                sub(/\.(h|cpp)$/, "", file)
            }
            return file
        }
        $2 ~ /^bsoil\// && $2 !~ /^bsoil\/(bullet|c)\// { next }
        room($1) != room($2) { print room($1), room($2) }' | sort -u)
if ! circles=$(tsort <<<"$arrows" 2>&1 >/dev/null); then
    fail "includes of bridge/ run in a circle:"$'\n'"$circles"
fi
exit "$failed"
