#!/bin/sh
# SPDX-License-Identifier: GPL-3.0-or-later
# A new user's first half hour, by mouse and keyboard, with a picture of each step. Then every
# number that the window shows is compared with the files that were exported from it:
#   sh scripts/pictures/first_use.sh BLENDER WIDTHxHEIGHT ZIP OUT
# BLENDER is the program (4.3 and 5.2 work), ZIP the file that `make zip` wrote, OUT a folder for
# pictures, exported files and the report of the comparison. Needs Xvfb, xdotool and ImageMagick's
# `import`. Mouse positions count from the right and upper edges, as Blender lays out its sidebar,
# so they hold at any size from 1280x720 on. The exit status is that of the comparison.
set -eu
blender=$1 size=$2 zip=$3 out=$4
w=${size%x*} h=${size#*x}
home=$(mktemp -d)
export BLENDER_USER_RESOURCES="$home" DISPLAY=":${SCREEN:-87}" SHOWN_WHEN="$home/compare"
mkdir -p "$out"
cp "${HOME_BLEND:-sample_blends/angen.blend}" "$home/home.blend"
"$blender" --command extension install-file -r user_default -e "$zip" >"$out/blender.log" 2>&1
Xvfb "$DISPLAY" -screen 0 "${size}x24" +extension GLX -nolisten tcp >/dev/null 2>&1 &
screen=$! window=
trap 'kill $window $screen 2>/dev/null; rm -rf "$home"' EXIT
sleep 2
# The sidebar's tabs, the centre of its panels, and the frame numbers of the timeline.
tabs=$((w * 815 / 1000)) middle=$((w * 815 / 1000 - 142)) frames=$((h - h * 28 / 360 + 17))
# Blender 5 has one more tab above them.
case $("$blender" --version | head -1) in *" 4."*) tab=254 ;; *) tab=330 ;; esac

open() {
    "$blender" -p 0 0 "$w" "$h" --no-window-focus "$home/home.blend" --python-expr 'import bpy
bpy.context.preferences.view.show_splash = False' --python scripts/shown_numbers.py \
        -- "$home/home.csv" "$home/home samples" "$out/compared.csv" >>"$out/blender.log" 2>&1 &
    window=$!
    sleep 12
    settle
    view
    click "$tabs" "$tab"
}
# Wait until two pictures of the window are equal: on a busy machine that takes a while.
settle() {
    last='' n=0
    while [ $n -lt 30 ]; do
        sleep 0.4
        now=$(import -window root -depth 8 rgb:- | cksum)
        [ "$now" != "$last" ] || return 0
        last=$now n=$((n + 1))
    done
}
at() { xdotool mousemove $(($1 - 4)) "$2"; sleep 0.2; xdotool mousemove "$1" "$2"; settle; }
click() { at "$1" "$2"; xdotool mousedown 1; sleep 0.2; xdotool mouseup 1; settle; }
panel() { click $((middle + $1)) "$2"; }
key() { for k in "$@"; do xdotool key "$k"; settle; done; }
view() { at $((w / 5)) $((h / 2)); }
text() { xdotool type --delay 80 "$1"; settle; }
# Press the button of a file browser, whose window opens in the centre, with the proposed name.
accept() { click $((w / 2 + 480)) $((h / 2 + 291)); }
picture() { sleep "${2:-1}"; import -window root "$out/$1.png"; }

open; picture 01_opened
view; key shift+a; text "motion detector on"; key Return; at $((w * 495 / 1000)) $((h * 352 / 1000))
picture 02_placing
click $((w * 495 / 1000)) $((h * 352 / 1000)); picture 03_placed 5
view; key ctrl+z; sleep 1
panel 0 128; text "PIR hall"; key Return; panel -30 184
click $((w * 16 / 100)) "$frames"; picture 04_scrubbed 2
view; key shift+alt+Right shift+alt+Right shift+alt+Right; picture 05_third_event
panel -70 381; panel 0 518; picture 06_explained 3
panel -70 381
panel -70 515; accept; picture 07_events_written
panel 0 515; accept
panel 85 515; accept; picture 08_report_written 3
panel -60 567; picture 09_baked 2
view; key ctrl+z; sleep 1
key g x; text 0.5; key Return; picture 10_stale 4
view; key ctrl+z; picture 11_undone 3
key ctrl+s; sleep 3
kill "$window"; wait "$window" || true
open; picture 12_reopened
: >"$SHOWN_WHEN"
for _ in $(seq 120); do sleep 2; [ ! -s "$SHOWN_WHEN" ] || break; done
picture 13_compared
panel 0 438; picture 14_simulating 14
view; key Escape; picture 15_stopped 3
cp -r "$home"/home.csv "$home"/home.html "$home/home samples" "$out" || true
grep -E "^(differs|compared)" "$out/blender.log" || true
exit "$(cat "$SHOWN_WHEN")"
