#!/usr/bin/env bash
# Checks that a number of the mechanics of contact says what it is: each member of ContactLawDef, ContactMotionDef and CouplingDef has its unit or
# range, where its value is from, and what another one would do; so do real constants of plugin/src/contact and plugin/src/host;
# each constant of bridge/src has a comment; a large number in a kernel has a name.
source "$(dirname "${BASH_SOURCE[0]}")/check.sh"

# Members with a value, each with the comment above it; several members on a line share one.
while IFS= read -r found; do
    fail "$found"
done < <(awk '
    FNR == 1 { text = ""; in_struct = 0 }
    /^struct (ContactLawDef|ContactMotionDef|CouplingDef)/ { in_struct = 1 }
    /^};/ { in_struct = 0 }
    !in_struct { next }
    /^ *\/\/\// { text = text " " substr($0, index($0, "///") + 3); next }
    /^ *(double|int|bool) [a-z_]+ = .*;/ {
        at = FILENAME ":" FNR ": " $2
        if ($1 != "bool") {
            if (text !~ /Ours|ours|\([12][0-9][0-9][0-9]\)|[A-Z][a-z]+ gives|Rankine/) print at ": where is its value from?"
            if (text !~ /[Ll]arger|[Ss]maller|[Hh]igher|[Ll]ower|[Ll]onger|[Ss]horter/) print at ": what would another value do?"
            if ($2 !~ /_(m|s|m_s|voxels|voxels_per_s|share|cosine|sine|widths|steps)$/ && text !~ /\[[a-z\/ ]+\]|[0-9]\.\.[0-9]/)
                print at ": which unit, which range?"
        }
    }
    /;/ || /^$/ { text = "" }' plugin/include/bsoil/contact/contact_{law_def,motion}.h bridge/src/coupling_def.h)

# A constant with a number has a comment beside it or above it; those that name no number need none.
while IFS= read -r found; do
    fail "$found: a constant without a comment"
done < <(awk '
    FNR == 1 { above = "" }
    /^ *(inline |static )*constexpr [a-zA-Z_:0-9<>]+ k[A-Z][A-Za-z_0-9]* = *[-0-9(~]/ && $0 !~ /\/\// && above !~ /\/\// {
        print FILENAME ":" FNR ": " $0
    }
    # A comment holds for a run of constants.
    { if ($0 !~ /^ *(inline |static )*constexpr / || $0 ~ /\/\//) above = $0 }' $(git ls-files plugin/src/contact plugin/include/bsoil/contact bridge/src))
# In the contact wing a real number says where it is from and what another one would do.
while IFS= read -r found; do
    fail "$found"
done < <(awk '
    FNR == 1 { text = "" }
    /^ *\/\// { text = text " " $0; next }
    /^ *(inline |static )*constexpr double k[A-Z][A-Za-z_0-9]*(\[\])? = [-0-9{]/ {
        at = FILENAME ":" FNR
        if (text !~ /Ours|\([12][0-9][0-9][0-9]\)/) print at ": where is this number from?"
        if (text !~ /[Ll]arger|[Ss]maller|[Hh]igher|[Ll]ower|[Ll]onger|[Ss]horter/) print at ": what would another number do?"
        next
    }
    { text = "" }' $(git ls-files plugin/src/contact plugin/include/bsoil/contact plugin/src/host))
# A number of three figures in a kernel has a name; what spreads bits for chance ends in u.
while IFS= read -r found; do
    fail "$found: a number without a name"
done < <(for file in shaders/*.glsl; do
    sed 's,//.*,,' "$file" | grep -nE '(^|[^0-9A-Za-z_.])[0-9]{3,}([^0-9A-Za-z_]|$)' | grep -vE 'CONST_INT\(|#version' | sed "s,^,$file:,"
done)
exit "$failed"
