#!/usr/bin/env bash
# Makes the pictures of docs/gallery.md again, and the page: demos/gallery.sh [--films] [NAME...]
#   --films  a film of each as well, out/gallery/NAME.mp4 (needs ffmpeg)
#   NAME     only these pictures
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

films=0
if [[ ${1:-} == --films ]]; then
    films=1
    shift
fi

# name | scene | steps of the soil until the picture | options of bsoil render | what one sees
pictures=(
    "trench|excavator|2532||An excavator at its cuts: the walls of undisturbed soil stand steep, what was dumped lies loose behind."
    "scoop|scoop|500||A bucket comes up out of moist sand: a heap on it, soil that runs off its rim, the hole it left and what it pushed aside."
    "tracks|tracked|800||Each shoe of a track is a body. Lugs leave their marks, and the vehicle's weight its two ruts."
    "ruts|four_wheels|800|--eye -0.6 -4.4 2.2 --target -1.4 0 0.4|Four wheels on loose sand: ruts with berms on both sides, the rear wheels in those of the front."
    "buggy|buggy|420||A btRaycastVehicle has driven a bend on loose sand: its wheels are rays for Bullet, for the soil they are wheels that sink and leave ruts."
    "berm|bulldozer|600||A blade pushes a heap ahead; windrows lie beside its path, a ridge where it began."
    "pipe|pipe|520|--eye 3.1 -1.9 1.2 --target 0.9 0 0.65|Sand out of a pipe: what falls thinly is drawn as grains, as many as there is soil. The heap ends in a cut face at the open edge."
    "cart|loading|42|--eye 0.1 -3.3 3.2 --target -0.5 0 0.5|A cart coasts under a hopper. It slows down by the sand that it takes along: its momentum is that of both."
    "silo|silo|64|--eye 0.6 -5.2 1.9 --target 0 0 1.05|Two silos with 600 kg of sand each. A motor of 3 kN holds the left gate, for the walls bear most by friction; one of 2 kN has given way."
    "throw|throw|64||A blade at 4 m/s has stopped, and its heap goes on. Paddles throw sand behind them, a ball has fallen in."
    "heap|column|400||A column of dry sand has come down: a cone at the angle of repose, equally steep in every direction."
    "terrain|terrain|400||Sand poured on rock: it piles up where the rock is flat and runs down into hollows."
    "layers|layers|440||A scoop has cut through topsoil and clay into gravel. What it tips out shows all three side by side, each by its share."
    "piles|deposits|1200||A solid, sand, a thick and a thin liquid, and snow: they differ by friction, roughness and viscosity alone."
    "castle|sand_castle|1200||Four towers of sand in the rain: dry, moist under a roof, wet to the brim, and moist without a roof."
    "piers|groundwater|3600||Three piers on wet ground: gravel lies, silty sand stands by the water it draws up, and falls where a pipe has burst in it."
    "drift|snow_drift|840||Snow has come down in a gusty wind: on the roof, in a drift before the house, and little in its lee."
    "avalanche|block|180||A column of sand comes down on a block. What rolls and what pours over the edges is drawn as grains, with dust over it."
    "blocks|blocks|90||Blocks of several heights in a falling column: the piles on them and around them join."
    "plates|two_plates|210||Two plates carry soil away. The one without friction leaves its heap behind."
    "blade|slow_blade|1320||A blade has been drawn through sand for 22 seconds, half a voxel a second."
    "divide|moving_plate|52||A plate parts the soil in two at a voxel a step. Nothing leaks to the other side."
    "buckets|full_bucket|300|--eye 1.0 -1.3 1.2 --target 0 0 0.42|Two buckets full of sand on sand: one bears its weight, one is pressed down by a motor."
    "thin|thin_bucket|720||A bucket of thin plate, full of sand, swings and tilts."
    "bekker|bekker_plates|150||Three plates in sand that answers by Bekker's parameters: the force on each is what his formula says."
    "trapped|trapped_soil|120||Two arms press on a thin layer of sand, and a block has fallen on it."
    "weights|pebble_and_excavator|140||A pebble of 5 g, a block, a drum and a machine of 20 t at rest on one soil."
)
# Scenes without a picture, and why.
without=(
    "closed_box|shows a box and nothing else: what it proves is that nothing leaks"
    "husky|needs a robot's files that are not part of the project"
    "zx200|needs an excavator's files that are not part of the project"
)

folder=$project_root/docs/images/gallery
bsoil=$project_root/build/demos/bsoil
install_packages "${build_packages[@]}" || exit 2
configure "$project_root/build" CMAKE_BUILD_TYPE?=Release BULLETSOIL_TESTS?=OFF || exit 2
build "$project_root/build" bsoil || exit 2
mkdir -p "$folder"

page=$project_root/docs/gallery.md
{
    echo '# Gallery'
    echo
    echo 'Made by `demos/gallery.sh`, scene by scene out of `demos/scenes/`; with `--films` each is a film, too.'
} >"$page"
for entry in "${pictures[@]}"; do
    IFS='|' read -r name scene steps options text <<<"$entry"
    printf '\n## %s\n\n![%s](images/gallery/%s.jpg)\n\n%s `demos/run.sh %s`, step %s.\n' \
        "${name^}" "$text" "$name" "$text" "$scene" "$steps" >>"$page"
    if (($#)) && [[ " $* " != *" $name "* ]]; then
        continue
    fi
    say "$name"
    # shellcheck disable=SC2086 # options are words
    "$bsoil" render "$project_root/demos/scenes/$scene.toml" --advance "$steps" --width 960 --height 540 $options \
        --out "$folder/$name.jpg"
    if ((films)); then
        # A run's own checks may fail on so few steps.
        "$bsoil" run "$project_root/demos/scenes/$scene.toml" --steps "$steps" --video --out "$project_root/out/gallery/$name" || (($? == 1))
        mv "$project_root/out/gallery/$name/video.mp4" "$project_root/out/gallery/$name.mp4"
    fi
done
{
    printf '\n## Scenes without a picture\n\n'
    for entry in "${without[@]}"; do printf -- '- `%s` %s.\n' "${entry%%|*}" "${entry#*|}"; done
} >>"$page"
