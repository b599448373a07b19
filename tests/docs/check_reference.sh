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
# page NAME TEXT...: the page is there and has these.
page() {
    local text name=$1
    shift
    for text in "$@"; do
        grep -qsF -- "$text" "html/$name.html" && continue
        printf '%s.html has no %s\n' "$name" "$text"
        exit 1
    done
}
page index BulletSoil structbsoil_1_1SoilDef.html
page classbsoil_1_1Soil surface_height_m
page classbsoil_1_1bullet_1_1SoilAction body_report
page namespacebsoil translate
page bulletsoil_8h bulletsoil_create
! grep -v '(variable) of .* is not documented' warnings
