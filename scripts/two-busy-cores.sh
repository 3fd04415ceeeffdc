#!/usr/bin/env bash
# How late events are while a busy program runs on every core at the usual priority: from a frame to its events, and to the key that
# an X11 client could see, with gelpad's own priority and without it (`nice` limit 0, as a user without RealtimeKit).
#
#   scripts/two-busy-cores.sh [SECONDS [GELPAD]]      60 s each by default; needs xvfb
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
gelpad=$(realpath "${2:-target/release/gelpad}")
work=$(mktemp -d)
chmod 755 "$work"
started=()
trap 'kill "${started[@]}" 2>/dev/null || true; wait 2>/dev/null || true; rm -rf "$work"' EXIT

Xvfb -displayfd 3 -noreset -screen 0 640x480x24 -nolisten tcp 3>"$work/display" 2>/dev/null &
started+=($!)
until [ -s "$work/display" ]; do
  kill -0 "${started[0]}" 2>/dev/null || { echo "Xvfb did not start" >&2; exit 1; }
  sleep 0.1
done
DISPLAY=:$(cat "$work/display")
export DISPLAY XDG_CONFIG_HOME=$work
# Presses of 40 to 200 ms, three a second.
awk -v end="$seconds" 'BEGIN { for (at = 500; at < 1000 * end; at += 333) {
  printf "t:%d down 1 %d 50\nt:%d up 1\n", at, 76 + at % 9, at + 40 + at % 161 } }' >"$work/touches.txt"
for _ in $(seq "$(nproc)"); do
  (while :; do :; done) &
  started+=($!)
done

play() {
  "$@" "$gelpad" play super-mario --source "simulated:$work/touches.txt" --output keyboard --headless --seed 1 >"$work/said" 2>&1 ||
    { cat "$work/said" >&2; exit 1; }
  grep -E 'frame to|by stage|late' "$work/said" | sed 's/^/  /'
}
echo "with gelpad's priority:"
play env
echo "without:"
# Root may always ask for a higher priority, so another user plays.
mkdir -m 777 "$work/home"
play setpriv --reuid=65534 --regid=65534 --clear-groups env -u XDG_RUNTIME_DIR HOME="$work/home" XDG_CONFIG_HOME="$work/home" prlimit --nice=0:0
