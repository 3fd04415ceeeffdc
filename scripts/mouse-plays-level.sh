#!/usr/bin/env bash
# Plays the practice level to its end with the mouse on the simulated pad: one finger is pinned on "right", the other jumps.
#
#   scripts/mouse-plays-level.sh [GELPAD [PICTURE.png]]
#
# The jump times are SOLUTION in src/gui/practice/level.rs; after a fall, the script jumps at regular intervals. Needs the packages of
# see-window.sh.
set -euo pipefail
cd "$(dirname "$0")/.."

picture=${2:-}
. scripts/window-stage.sh "${1:-target/release/gelpad}"
open_window
sleep 1
xdotool key F2
sleep 1

# Positions of "right" and "jump" on the pad in the practice view at 1280 x 800, px.
right=(1100 600)
jump=(1210 615)
done_s() { sed -n 's/^best_s = //p' "$work/gelpad/window.toml" 2>/dev/null; }

chain=(mousemove "${right[@]}" mousedown 1 sleep 0.04 key space mouseup 1 mousemove "${jump[@]}")
at=50
while read -r from long; do
  chain+=(sleep "$(awk "BEGIN { print ($from - $at) / 1000 }")" mousedown 1)
  chain+=(sleep "$(awk "BEGIN { print $long / 1000 }")" mouseup 1)
  at=$((from + long))
done < <(sed -nE 's/^ +\(([0-9]+), ([0-9]+)\),$/\1 \2/p' src/gui/practice/level.rs)
xdotool "${chain[@]}"
for _ in $(seq 200); do
  [ -z "$(done_s)" ] || break
  xdotool mousedown 1 sleep 0.35 mouseup 1 sleep 0.35
done
[ -z "$picture" ] || import -silent -window "$window" "$picture"
[ -n "$(done_s)" ] || { echo "the level was not finished" >&2; exit 1; }
printf "the level was finished by mouse in %.1f s\n" "$(done_s)"
