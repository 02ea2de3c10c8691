#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# Makes the docs' pictures anew:   sh scripts/pictures/make.sh BLENDER [NAME…]
# BLENDER is the program; needs Xvfb and ImageMagick (apt install xvfb imagemagick). NAME is a picture
# of docs/pictures without its ending; all of them without one. Not made here: what `make bench`
# draws (*.svg of figures). Two homes are not in this repository; HOMES is a folder with them:
#   bedroom.glb  public/models/bedroom.glb of https://github.com/QuirkyCort/iot-sim
#   home.obj     AC20-FZK-Haus.ifc of the KIT (https://www.ifcwiki.org, KIT IFC Examples), converted by
#                scripts/foreign_homes/ifc_to_obj.py
# Without HOMES the pictures of these homes stay as they are.
set -eu
cd "$(dirname "$0")/../.."
blender=$1
shift
wanted=$*
home=$(mktemp -d) out=docs/pictures
mkdir -p "$home/extensions/user_default"
ln -s "$PWD" "$home/extensions/user_default/angen_sensors"
export BLENDER_USER_RESOURCES="$home" DISPLAY=":${SCREEN:-93}"
addon="--factory-startup --addons bl_ext.user_default.angen_sensors"
pids=
trap 'kill $pids 2>/dev/null || true; rm -rf "$home"' EXIT
failed=

chosen() { [ -z "$wanted" ] || case " $wanted " in *" $1 "*) ;; *) return 1 ;; esac; }
# Waits until the log has COUNT lines of a word, for two minutes at most.
lines() { grep -c "^$1" "$home/log" || true; }
wait_for() {
    tries=0
    while [ "$(lines "$1")" -lt "$2" ]; do
        tries=$((tries + 1))
        [ $tries -lt 1200 ] && kill -0 "$window" 2>/dev/null || return 1
        ! grep -q ^Traceback "$home/log" || return 1
        sleep 0.1
    done
}
shoot() { import -window root "$1"; }
# A picture of Blender's window: NAME SIZE SCENE FILE [VARIABLE=VALUE].
window() {
    chosen "$1" || return 0
    name=$1 size=$2 scene=$3 file=$4
    : >"$home/log"
    [ $# -lt 5 ] || export "$5"
    Xvfb "$DISPLAY" -screen 0 "${size}x24" +extension GLX -nolisten tcp >/dev/null 2>&1 &
    screen=$!
    sleep 1
    # shellcheck disable=SC2086  # a list of options
    PICTURE=$scene "$blender" $addon -p 0 0 "${size%x*}" "${size#*x}" --no-window-focus $file \
        --python scripts/pictures/scenes.py >"$home/log" 2>&1 &
    window=$!
    pids="$window $screen"
    if [ "$scene" = scrub ]; then
        shot=1
        while wait_for "SHOT" $shot; do
            shoot "$home/scrub$(printf %02d $shot).png"
            shot=$((shot + 1))
        done
        convert -delay 16 -loop 0 "$home"/scrub*.png -resize 880x -quality 60 "$out/$name.webp" &&
            made "$name.webp" || lost "$name"
    elif wait_for READY 1; then
        sleep 0.7
        shoot "$home/$name.png"
        convert "$home/$name.png" -quality 82 "$out/$name.jpg" && made "$name.jpg"
    else
        lost "$name"
    fi
    kill $window $screen 2>/dev/null || true
    wait 2>/dev/null || true
}
made() { echo "$out/$1  $(wc -c <"$out/$1") bytes"; }
lost() {
    failed="$failed $1"
    echo "!!! $1 was not made:" >&2
    tail -20 "$home/log" >&2
}
# A picture that a command line writes: FILE COMMAND…
written() {
    file=$1
    shift
    chosen "${file%.*}" || return 0
    # shellcheck disable=SC2086
    "$blender" $addon sample_blends/angen.blend --command angen "$@" >"$home/log" 2>&1 &&
        made "$file" || lost "$file"
}
# A render by a file's own camera: NAME FILE FRAME.
render() {
    chosen "$1" || return 0
    "$blender" -b --factory-startup "$2" --python-expr "import bpy
for frame in range(1, $3 + 1):  # physics needs all frames before
    bpy.context.scene.frame_set(frame)
render = bpy.context.scene.render
render.resolution_x, render.resolution_y, render.resolution_percentage = 960, 540, 100
render.engine, bpy.context.scene.cycles.samples = 'CYCLES', 256
bpy.context.scene.cycles.use_denoising = False
render.image_settings.file_format = 'PNG'" -o "$home/$1#" -f "$3" >"$home/log" 2>&1 || true
    ls "$home/$1"*.png >/dev/null 2>&1 || { lost "$1"; return; }
    convert "$home/$1"*.png -quality 85 "$out/$1.jpg" && made "$1.jpg"
}

# Whether a home of HOMES is there, for one of these pictures: FILE NAME…
foreign() {
    file=$1
    shift
    for name; do chosen "$name" && break; done || return 1
    [ -f "${HOMES:-}/$file" ] || { echo "left as they are, for HOMES/$file is missing: $*"; return 1; }
    cp "$HOMES/$file" "$home"
}
# Run a page's Python block that has a WORD beside the home: PAGE WORD FILE.
# It is saved as FILE.
block() {
    awk -v RS='```' "/$2/" "$1" | sed 1d >"$home/block.py"
    echo "bpy.ops.wm.save_as_mainfile(filepath='$3')" >>"$home/block.py"
    # shellcheck disable=SC2086
    (cd "$home" && "$blender" -b $addon --python-exit-code 1 --python block.py) >"$home/log" 2>&1
}

home_file=sample_blends/angen.blend
window scrub 1280x720 scrub $home_file
window overlay_motion 1600x900 overlay $home_file
window authoring_place 1400x788 place $home_file
window timeline_history 1500x1050 timeline $home_file
window coverage_window 1320x812 coverage $home_file
window day_window 1240x900 day $home_file
window places_window 1240x785 places $home_file
window pir_pyroelectric 1280x960 pyroelectric $home_file
window residents 1316x760 residents ""
window atelier 1120x800 atelier sample_blends/atelier.blend
window distance_zones 1310x790 distance ""
window thermal_array 1600x900 thermal_array $home_file
window presence_radar 1600x900 presence_radar $home_file
window contact_rings 1310x790 contact ""
window switch_swept 1310x790 switch ""
written report.svg simulate --quiet --report "$out/report.svg" --events "$home/events.csv"
written coverage_home.svg coverage --quiet --motion ARM --picture "$out/coverage_home.svg"
render pressure_sample sample_blends/pressure.blend 20
if foreign bedroom.glb your_own_home_before your_own_home_after; then
    # shellcheck disable=SC2086
    block docs/your_own_home.md import_scene.gltf bedroom.blend && (cd "$home" &&
        "$blender" $addon bedroom.blend --command angen place --count 1 --save bedroom_pir.blend) \
        >"$home/log" 2>&1 || lost bedroom.blend
    window your_own_home_before 1180x700 imported "" HOME_MODEL="$home/bedroom.glb"
    window your_own_home_after 1180x700 prepared "$home/bedroom_pir.blend"
fi
if foreign home.obj places_ifc; then
    block docs/residents.md wm.obj_import ifc.blend || lost ifc.blend
    window places_ifc 1180x760 places_ifc "$home/ifc.blend"
fi
[ -z "$failed" ] || { echo "not made:$failed" >&2; exit 1; }
