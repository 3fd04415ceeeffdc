#!/usr/bin/env bash
# A million frames from the simulated board to `gelpad listen`, as fast as the pseudo-terminal takes them: none may be
# missing or garbled. Then the whole pipeline at 1000 frames/s on one core, with the latencies that `gelpad play` says.
# usage: scripts/million-frames.sh [FRAMES]      (GELPAD: the program, target/release/gelpad by default)
set -euo pipefail
cd "$(dirname "$0")/.."

frames=${1:-1000000}
gelpad=${GELPAD:-target/release/gelpad}
folder=$(mktemp -d)
trap 'kill "${board:-}" 2>/dev/null || true; rm -rf "$folder"' EXIT

serve() {
  "$@" 2>"$folder/board" &
  board=$!
  while [ ! -e "$folder/port" ]; do sleep 0.05; done
}

echo "== $frames frames without a rate"
serve "$gelpad" device --port "$folder/port" --format gelpad --rate 0 --frames "$frames"
report=$("$gelpad" listen "$folder/port" --format gelpad --frames "$frames" --seconds 3600)
echo "$report"
wait "$board" || true
grep -q "^frames *$frames\b" <<<"$report"
grep -q "^garbled *0$" <<<"$report"
if grep -q "missing" <<<"$report"; then exit 1; fi

echo "== 1000 frames/s through the pipeline, gelpad on one core"
serve "$gelpad" device --port "$folder/port" --format gelpad --rate 1000 --frames 30000
taskset -c 0 "$gelpad" play --headless --output trace --format gelpad --source "serial:$folder/port" >/dev/null 2>"$folder/play" &
play=$!
wait "$board" || true
sleep 1
kill -TERM "$play"
wait "$play" || true
grep -E "frames|events|device" "$folder/play"
