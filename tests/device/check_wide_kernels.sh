#!/usr/bin/env bash
# The kernels for wider vectors hold nothing that a linker may take for code outside of them: check_wide_kernels.sh ARCHIVE OBJECT.
# An inline function compiled for AVX2 would stop every other processor.
set -euo pipefail
archive=$1 object=$2
symbols=$(nm -C "$archive" | awk -v object="$object" '/\.o:$/ { inside = $0 == object ":" } inside && NF > 1')
grep -q ' T bsoil::device::soil_wide_kernels()$' <<<"$symbols" || { echo "no $object in $archive" >&2; exit 1; }
if grep -E ' [TWVu] ' <<<"$symbols" | grep -vE ' (bsoil::device::soil_wide_kernels\(\)|.*glm_wide::.*|DW\.ref\.__gxx_personality_v0)$'; then
    echo "$object shares these with other objects" >&2
    exit 1
fi
