#!/usr/bin/env bash
# Plays the supertux profile into SuperTux and prints how many of the game's steps (64 per second) each key was down.
# Needs the Debian packages xvfb, xdotool, supertux and python3; uses its own display.
#
#   scripts/see-in-supertux.sh [PROFILE]
set -euo pipefail
source "$(dirname "$0")/stage.sh"
stage 800x600
supertux
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
play "${1:-supertux}"
sleep 2
kill "$game"
keys_seen
