#!/usr/bin/env bash
# Checks that a page says what the command that writes its tables finds: check_page.sh BSOIL FOLDER PAGE COMMAND...
# Runs the command with a copy of the page as its --document and compares text and pictures.
# Exit code: 0 the same, 1 not, or an expectation of an experiment fails, 77 some measured data is not there: not compared.
set -uo pipefail
bsoil=$1 folder=$2 page=$3
shift 3
rm -rf "$folder"
mkdir -p "$folder"
copy=$folder/$(basename "$page") pictures=$(basename "$page" .md)
cp "$page" "$copy"
BULLETSOIL_DATA=${BULLETSOIL_DATA:-$(cd "$(dirname "$page")/../../shared/data" 2>/dev/null && pwd)} "$bsoil" "$@" --document "$copy" |
    tee "$folder/output.txt"
code=${PIPESTATUS[0]}
if [[ $code == 77 ]]; then exit 77; fi
failed=0
# 1: a gate of the validation is not met, as its page says; an experiment's expectations have to hold.
((code == 0)) || [[ $code == 1 && $1 == validate ]] || failed=1
diff -u "$page" "$copy" || failed=1
for picture in "$folder/$pictures"/*.svg; do
    [[ -f $picture ]] || continue
    cmp "$picture" "$(dirname "$page")/$pictures/$(basename "$picture")" || failed=1
done
((failed)) && exit 1
if grep -q '^SKIP ' "$folder/output.txt"; then exit 77; fi
