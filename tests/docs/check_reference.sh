#!/usr/bin/env bash
# Makes the reference out of the public headers (check_reference.sh FOLDER, the one with the Doxyfile) and fails where Doxygen
# complains: a class, function or type without a comment, a reference to something that is not there. Members whose names
# say what they are need no comment. Exit codes: 0 passed, 1 failed, 77 there is no Doxygen.
set -uo pipefail
cd "$1" || exit 1
if ! command -v doxygen >/dev/null; then
    printf 'doxygen is not installed\n'
    exit 77
fi
rm -rf html warnings
doxygen Doxyfile || exit 1
for class in bsoil_1_1Soil bsoil_1_1bullet_1_1SoilAction bsoil_1_1render_1_1Renderer; do
    [[ -s html/class$class.html ]] && continue
    printf 'no page for %s\n' "$class"
    exit 1
done
! grep -v '(variable) of .* is not documented' warnings
