#!/usr/bin/env bash
# Plays the supertux profile into SuperTux and prints what the game saw: how many of its steps (64 a second) each key was
# down. Needs the Debian packages xvfb, xdotool, supertux and python3, and no display of yours.
#
#   scripts/see-in-supertux.sh [PROFILE]
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --quiet
gelpad=$PWD/target/debug/gelpad
profile=${1:-supertux}
folder=$(mktemp -d)
started=()
trap 'kill "${started[@]}" 2>/dev/null || true; rm -rf "$folder"' EXIT

Xvfb -displayfd 3 -nolisten tcp -screen 0 800x600x24 3>"$folder/display" &
started+=($!)
until [ -s "$folder/display" ]; do sleep 0.1; done
export DISPLAY=:$(cat "$folder/display") XDG_RUNTIME_DIR=$folder HOME=$folder

SDL_RENDER_DRIVER=software SDL_AUDIODRIVER=dummy PATH=$PATH:/usr/games supertux2 --userdir "$folder/user" --window \
  --geometry 640x480 --disable-sound --disable-music --renderer sdl --record-demo "$folder/demo" \
  /usr/share/games/supertux2/levels/world1/welcome_antarctica.stl >"$folder/said" 2>&1 &
game=$!
started+=("$game")
xdotool search --sync --onlyvisible --class supertux2 windowfocus --sync
sleep 20 # the level has begun, on a slow machine too

cat >"$folder/touches.txt" <<'TOUCHES'
t:1000 down 1 80 50   # jump, short and long
t:1150 up 1
t:2000 down 1 80 50
t:2500 up 1
t:3500 down 1 37 55   # right
t:4300 up 1
t:5000 down 1 13 55   # left
t:5800 up 1
t:6500 down 1 75 9    # run
t:7000 up 1
t:7500 down 1 20 15   # down
t:8000 up 1
TOUCHES
"$gelpad" play "$profile" --source "simulated:$folder/touches.txt" --output keyboard --headless --seed 1
sleep 2
kill "$game" # the demo is written out at the end
wait "$game" 2>/dev/null || true

# A header of 23 bytes, then six a step.
python3 - "$folder/demo" <<'PYTHON'
import sys
from itertools import groupby

steps = open(sys.argv[1], "rb").read()[23:]
for place, key in enumerate(["left", "right", "up", "down", "jump", "action"]):
    runs = [len(list(run)) for down, run in groupby(steps[place::6]) if down]
    print(f"{key:7} down for {runs} steps")
PYTHON
