#!/usr/bin/env bash
# Measures the cost of the window: time to open, repaints per second at 100 frames/s, CPU time of the engine per frame with and
# without the window, and CPU usage while the game is paused.
#
#   scripts/window-cost.sh [GELPAD] [SECONDS]
#
# CPU times are from /proc/PID/task/TID/schedstat, so other programs do not count; opening and repaints are wall-clock. Needs the
# packages of see-window.sh.
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

start=$(date +%s%N)
open_window
echo "opens: $((($(date +%s%N) - start) / 1000000)) ms until the pad plays"
sleep 6
before=$(engine_ns "$player"); whole=$(process_ticks "$player")
for _ in $(seq 1 2 "$seconds"); do
  xdotool mousemove 580 330 mousedown 1; sleep 0.7; xdotool mouseup 1; sleep 1.3
done
after=$(engine_ns "$player"); whole=$(($(process_ticks "$player") - whole))
span=$((($(seq 1 2 "$seconds" | wc -l)) * 2))
shown=$(((after - before) / (span * 100)))
echo "engine with the window: $shown ns CPU per frame, $(awk "BEGIN{printf \"%.2f\", $shown / $headless}") times"
grep -o 'repaints: .*' "$work/log" | tail -5
echo "whole program: $((whole / span)) % of a core"

# Pause: the button is in the upper right.
xdotool mousemove 993 182 click 1
sleep 4
before=$(process_ticks "$player"); sleep "$seconds"; after=$(process_ticks "$player")
echo "paused: $(awk "BEGIN{printf \"%.1f\", ($after - $before) / $seconds}") % of a core"
