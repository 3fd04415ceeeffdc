#!/usr/bin/env bash
# Measures the cost of the window with software OpenGL: time to open, CPU time of the engine per frame with and without the window,
# and of the whole program at rest, while a finger presses, paused and minimised; memory.
#
#   scripts/window-cost.sh [GELPAD] [SECONDS]
#
# CPU times are those of the process (/proc/PID/stat and schedstat), so other programs do not count; opening and repaints are
# wall-clock. Goals: at rest 10 % of a core, playing 40 %, minimised 3 %, memory 150 MB. Needs the packages of see-window.sh, and
# x11-utils for xprop: without a window manager, the script itself marks the window as minimised.
set -euo pipefail

seconds=${2:-20}
. "$(dirname "$0")/window-stage.sh" "${1:-target/release/gelpad}"

# CPU time of the `engine` thread of a process, ns.
engine_ns() {
  for task in /proc/"$1"/task/*; do
    if [ "$(cat "$task/comm")" = engine ]; then cut -d' ' -f1 "$task/schedstat"; fi
  done
}
# CPU time of a process, in ticks of 10 ms.
process_ticks() { awk '{print $14 + $15}' "/proc/$1/stat"; }

# The simulated pad at 100 frames/s, with a finger that presses for 0.7 s every 2 s.
{
  for s in $(seq 1 2 $((seconds + 20))); do
    printf 't:%d down 1 80 50\nt:%d up 1\n' $((s * 1000)) $((s * 1000 + 700))
  done
} >"$work/script.txt"
"$gelpad" play --source "simulated:$work/script.txt" --output trace --headless >"$work/events" 2>"$work/headless" &
player=$!
sleep 6
before=$(engine_ns "$player"); sleep "$seconds"; after=$(engine_ns "$player")
headless=$(((after - before) / (seconds * 100)))
kill -INT "$player"; wait "$player" 2>/dev/null || true
echo "engine without the window: $headless ns CPU per frame"
grep 'frame to' "$work/headless" || true

# CPU usage of the whole program for $seconds, and its repaints, with a title.
usage() {
  local before after lines
  lines=$(wc -l <"$work/log")
  before=$(process_ticks "$player"); sleep "$seconds"; after=$(process_ticks "$player")
  local repaints
  repaints=$(awk -F'repaints: ' -v seen="$lines" 'NR > seen && NF > 1 {n += $2} END {print n + 0}' "$work/log")
  echo "$1: $(awk "BEGIN{printf \"%.1f\", ($after - $before) / $seconds}") % of a core, $((repaints / seconds)) repaints a second"
}

# The first start of all: nothing is solved, and the table is solved in the background.
start=$(date +%s%N)
GELPAD_CACHE="$work/cache" open_window
opened=$((($(date +%s%N) - start) / 1000000))
echo "first start: $opened ms until the pad plays, $(($(process_ticks "$player") * 10)) ms of them CPU; a press counts 10 frames later"
kill "$player"; wait "$player" 2>/dev/null || true

start=$(date +%s%N)
open_window
echo "opens: $((($(date +%s%N) - start) / 1000000)) ms until the pad plays"
sleep 8
usage "at rest"
before=$(engine_ns "$player")
for _ in $(seq 1 2 $((seconds + 2))); do
  xdotool mousemove 580 330 mousedown 1; sleep 0.7; xdotool mouseup 1; sleep 1.3
done &
presser=$!
usage "playing, a press of 0.7 s every 2 s"
wait "$presser"
after=$(engine_ns "$player")
span=$((($(seq 1 2 $((seconds + 2)) | wc -l)) * 2))
shown=$(((after - before) / (span * 100)))
echo "engine with the window: $shown ns CPU per frame, $(awk "BEGIN{printf \"%.2f\", $shown / $headless}") times"
for _ in $(seq "$((seconds * 12))"); do
  xdotool mousemove $((500 + RANDOM % 200)) 330; sleep 0.06
done &
presser=$!
xdotool mousemove 580 330 mousedown 1
usage "playing, a finger that moves all the time"
wait "$presser"
xdotool mouseup 1
grep -E 'VmRSS|RssAnon|RssFile' "/proc/$player/status"
xprop -id "$window" -f _NET_WM_STATE 32a -set _NET_WM_STATE _NET_WM_STATE_HIDDEN
sleep 3
usage "minimised"
xprop -id "$window" -remove _NET_WM_STATE
# Pause: the button is in the upper right.
xdotool mousemove 993 182 click 1
sleep 4
usage "paused"
