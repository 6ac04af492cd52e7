#!/usr/bin/env bash
# Drives the real window under a virtual display: adds a node, draws, undoes, wires, builds, saves, is killed, recovers.
#
#     editor/tests/window/drive.sh target/release/orograph-editor [PICTURES]
#
# Needs xvfb and xdotool of Debian and a software Vulkan driver (mesa-vulkan-drivers); with a folder for PICTURES also
# imagemagick, and somebody who looks at them. What the other tests see through the accessibility tree goes past the
# window system, the graphics driver and the real clock; this does not. Ends with 0 when all was found as it should be.
set -euo pipefail

editor=$(realpath "$1")
pictures=${2:+$(mkdir -p "$2" && realpath "$2")}
work=$(mktemp -d)
graph=$work/first.ron
mkdir "$work/run" && chmod 700 "$work/run"

exec 3>"$work/display"
Xvfb -displayfd 3 -screen 0 1400x900x24 -nolisten tcp -noreset 2>"$work/xvfb.log" &
xvfb=$!
window_of=
trap '[ -z "$window_of" ] || kill -9 "$window_of" 2>/dev/null || true; kill $xvfb; rm -rf "$work"' EXIT

fail() { echo "failed: $*" >&2; cat "$work/editor.log" >&2; exit 1; }

# Waits until a command succeeds.
until_true() {
    for _ in $(seq 600); do
        "${@:2}" >/dev/null 2>&1 && return
        [ -z "$window_of" ] || kill -0 "$window_of" 2>/dev/null || fail "$1: the editor ended"
        sleep 0.1
    done
    fail "waited in vain: $1"
}

until_true "a display" test -s "$work/display"
DISPLAY=:$(tr -d '[:space:]' <"$work/display")
export DISPLAY

# A home of its own; neither desktop portal nor zenity, so that paths are typed.
open() {
    (cd "$work" && exec env -i DISPLAY="$DISPLAY" HOME="$work" XDG_RUNTIME_DIR="$work/run" PATH=/nonexistent \
        DBUS_SESSION_BUS_ADDRESS=unix:path=/nonexistent RUST_BACKTRACE=1 "$editor" "$@" 2>"$work/editor.log") &
    window_of=$!
    # It cannot have the keyboard before it is seen.
    until_true "a window with the keyboard" xdotool search --onlyvisible --name Orograph windowfocus
    sleep 2
}

calm() { sleep 0.5; }
keys() { xdotool key --delay 60 "$@"; calm; }
words() { xdotool type --delay 40 "$1"; calm; }
# At once, as a tap on a touchpad is.
click() { xdotool mousemove "$1" "$2"; sleep 0.2; xdotool click 1; calm; }
drag() {
    xdotool mousemove "$1" "$2"; sleep 0.2
    xdotool mousedown 1; sleep 0.1; shift 2
    while [ $# -gt 0 ]; do xdotool mousemove "$1" "$2"; sleep 0.1; shift 2; done
    xdotool mouseup 1; calm
}
picture() { [ -z "$pictures" ] || { sleep 2; import -window root "$pictures/$1.png"; }; }
kept() { grep -rqs -- "$1" "$work/.local/state/orograph/unsaved"; }
saved() { grep -qs -- "$1" "$graph"; }

open
xdotool mousemove 300 650
keys Tab
words "mcmd sketch"
keys Return
until_true "a node that was searched for is kept" kept mcmd.sketch
picture 1-node

# The tools stand at the left end of the bar over the view, whose picture is in the middle.
click 62 34
drag 450 200 500 230 560 300
until_true "a stroke is kept" kept "lines"
picture 2-stroke
keys ctrl+z
until_true "undo takes it back" bash -c "! grep -rqs lines: '$work/.local/state/orograph/unsaved'"
keys ctrl+shift+z
until_true "redo draws it again" kept "lines"

# A port is caught at the outer half of its disc; a node stands with its corner where the wire was dropped.
drag 487 706 560 650 700 600
words "mcmd"
keys Return
until_true "a dropped wire brings a node that it is wired to" kept "sketch.constraints"
drag 887 656 900 700 940 760
words "write geotiff"
keys Return
until_true "a writer" kept "mcmd.terrain"
keys ctrl+b
until_true "a build" test -s "$work/out/terrain.tif"

keys ctrl+s
keys ctrl+a
words "$graph"
keys Return
until_true "it is saved under a typed path" saved mcmd.mcmd

xdotool mousemove 100 500
keys Tab
words "fbm"
keys Return
until_true "unsaved work is kept" kept generate.fbm
picture 3-nodes
kill -9 "$window_of"; wait "$window_of" 2>/dev/null || true
window_of=
saved generate.fbm && fail "it was saved by nobody"

open
picture 4-recover
keys Tab
keys space
keys ctrl+s
until_true "what a crash left unsaved is recovered and saved" saved generate.fbm
picture 5-recovered
keys ctrl+q
for _ in $(seq 100); do kill -0 "$window_of" 2>/dev/null || break; sleep 0.1; done
kill -0 "$window_of" 2>/dev/null && fail "it does not quit"
window_of=
echo "all as it should be"
