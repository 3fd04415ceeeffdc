#!/usr/bin/env bash
# Makes the animated picture of the README from a real run: the mouse presses the simulated pad beside the practice level, one
# finger pinned on "right", and each jump is as high as its press is long.
#
#   docs/make-animation.sh OUT.gif [GELPAD]
#
# Needs the packages of scripts/see-window.sh. The jumps are those of SOLUTION in src/gui/practice/level.rs.
set -euo pipefail
cd "$(dirname "$0")/.."

out=$(realpath -m "${1:?the picture}")
seconds=9
period=0.08
. scripts/window-stage.sh "${2:-target/release/gelpad}"
open_window
sleep 1
xdotool key F2
sleep 2

# Positions of "right" and "jump" on the pad in the practice view at 1280 x 800, px.
right=(1100 600)
jump=(1210 615)
chain=(mousemove "${right[@]}" mousedown 1 sleep 0.04 key space mouseup 1 mousemove "${jump[@]}")
at=50
while read -r from long; do
  [ "$from" -lt $((seconds * 1000)) ] || break
  chain+=(sleep "$(awk "BEGIN { print ($from - $at) / 1000 }")" mousedown 1)
  chain+=(sleep "$(awk "BEGIN { print $long / 1000 }")" mouseup 1)
  at=$((from + long))
done < <(sed -nE 's/^ +\(([0-9]+), ([0-9]+)\),$/\1 \2/p' src/gui/practice/level.rs)

mkdir "$work/frames"
xdotool "${chain[@]}" &
plays=$!
count=$(awk "BEGIN { print int($seconds / $period) }")
start=$(date +%s%N)
for frame in $(seq -w "$count"); do
  cp "$screen" "$work/frames/$frame.xwd"
  # Frames keep their times, however long a copy takes.
  sleep "$(awk "BEGIN { wait = $((10#$frame)) * $period - ($(date +%s%N) - $start) / 1e9; print (wait > 0 ? wait : 0) }")"
done
wait "$plays"

# The view without the rail and the status line.
/usr/bin/env convert -delay 8 -loop 0 "$work"/frames/*.xwd -crop 1188x774+92+0 +repage -resize 700x -strip \
  +dither -colors 48 -layers OptimizeTransparency "$out"
ls -l "$out"
