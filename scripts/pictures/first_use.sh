#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# A new user's first half hour, by mouse and keyboard, with a picture of each step; at its end every
# number that the window shows is held against the files that were exported in it:
#   sh scripts/pictures/first_use.sh BLENDER WIDTHxHEIGHT ZIP OUT
# BLENDER is the program (4.3 and 5.2 were tried), ZIP what `make zip` wrote, OUT a folder for the
# pictures, events, samples, the report and what was compared. Needs Xvfb, xdotool and ImageMagick's
# `import`. The places that the mouse goes to are told from the window's right and upper edge, as
# Blender lays its sidebar out, so that they hold for every size from 1280x720 on.
set -eu
blender=$1 size=$2 zip=$3 out=$4
w=${size%x*} h=${size#*x}
home=$(mktemp -d)
export BLENDER_USER_RESOURCES="$home" DISPLAY=":${SCREEN:-87}" SHOWN_WHEN="$home/compare"
mkdir -p "$out"
cp sample_blends/angen.blend "$home/home.blend"
"$blender" --command extension install-file -r user_default -e "$zip" >"$out/blender.log" 2>&1

Xvfb "$DISPLAY" -screen 0 "${size}x24" +extension GLX -nolisten tcp >/dev/null 2>&1 &
screen=$!
trap 'kill $window $screen 2>/dev/null; rm -rf "$home"' EXIT
sleep 1
at() { xdotool mousemove "$1" "$2"; sleep 0.4; }
click() { at "$1" "$2"; xdotool click 1; sleep 0.8; }
# From the right edge; a panel is alone open once its header is clicked with Ctrl held.
right() { click $((w - $1)) "$2"; }
alone() { at $((w - $1)) "$2"; xdotool keydown ctrl click 1; sleep 0.3; xdotool keyup ctrl; sleep 0.8; }
key() { for k in "$@"; do xdotool key "$k"; sleep 0.6; done; }
view() { at $((w / 4)) $((h / 2)); }
picture() { sleep "${2:-0.7}"; import -window root "$out/$1.png"; echo "$1"; }
open() {
    "$blender" -p 0 0 "$w" "$h" --no-window-focus "$home/home.blend" --python-expr 'import bpy
bpy.context.preferences.view.show_splash = False' --python scripts/shown_numbers.py \
        -- "$out/home.csv" "$out/samples" "$out/compared.csv" >>"$out/blender.log" 2>&1 &
    window=$!
    sleep 14
    view
}
