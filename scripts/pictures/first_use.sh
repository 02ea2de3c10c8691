#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# A new user's first half hour, by mouse and keyboard, with a picture of each step:
#   sh scripts/pictures/first_use.sh ZIP OUT
# ZIP is what `make zip` wrote, OUT a folder for the pictures. Needs Xvfb, xdotool, ImageMagick's
# `import` and Blender 4.3, which BLENDER names where it is not `blender`: the places that the mouse
# goes to are those of its window at 1366 × 768, a small laptop's.
set -eu
zip=$1 out=$2 blender=${BLENDER:-blender}
home=$(mktemp -d)
export BLENDER_USER_RESOURCES="$home" DISPLAY=":${SCREEN:-87}"
mkdir -p "$out"
cp sample_blends/angen.blend "$home/home.blend"
"$blender" --command extension install-file -r user_default -e "$zip"

Xvfb "$DISPLAY" -screen 0 1366x768x24 +extension GLX -nolisten tcp >/dev/null 2>&1 &
screen=$!
trap 'kill $window $screen 2>/dev/null; rm -rf "$home"' EXIT
sleep 1
open() {
    "$blender" -p 0 0 1366 768 --no-window-focus "$home/home.blend" \
        --python-expr 'import bpy; bpy.context.preferences.view.show_splash = False' \
        >>"$out/blender.log" 2>&1 &
    window=$!
    sleep 9
    at 500 350
}
at() { xdotool mousemove "$1" "$2"; sleep 0.4; }
click() { at "$1" "$2"; xdotool click 1; sleep 0.6; }
key() { for k in "$@"; do xdotool key "$k"; sleep 0.5; done; }
scroll() { at 960 400; xdotool click --repeat "$2" --delay 60 "$1"; sleep 0.5; }
picture() { sleep "${2:-0.5}"; import -window root "$out/$1.png"; }
UP=4 DOWN=5

: >"$out/blender.log"
open
click 1114 253                                  # the sidebar's tab Sensors
picture 01_home 1
at 500 350; key shift+a; at 410 700; at 410 743; at 600 743; click 660 651  # Sensor, Motion detector on Surface
at 640 290; at 645 292
picture 02_placing
click 645 292
picture 03_placed 1.5
at 500 600; key ctrl+z
click 251 731; picture 04_scrubbed 3            # frame 100
click 970 412; at 500 350
picture 05_simulating 12
key Escape; picture 06_stopped 2
click 940 128; xdotool type --delay 60 "PIR hall"; key Return; click 920 184
at 500 350; key shift+alt+Right shift+alt+Right shift+alt+Right
picture 07_third_event 1
scroll $DOWN 4
picture 08_events
click 965 521; picture 09_explained 2
click 940 326; picture 10_baked 2
click 885 300; sleep 2; click 1162 675; picture 11_events_written 2
click 1050 300; sleep 2; click 1162 675; picture 12_report_written 4
at 300 500; key g x; xdotool type 0.5; key Return
picture 13_stale 1.5
key ctrl+z; picture 14_undone 3
key ctrl+s; sleep 4
kill "$window"; wait "$window" || true
open; click 1114 253; picture 15_reopened 1
click 970 97                                    # folds the table: presets come into sight
at 960 400; xdotool click --repeat 8 --delay 60 $DOWN
picture 16_active_sensor 1
cp "$home"/home.csv "$home"/home.html "$out"
