#!/usr/bin/env bash
# Kills a study again and again until it comes to its end, and compares what it wrote with an unbroken run's.
#
#   scripts/kill-a-study.sh [SECONDS [GELPAD]]
#
# The thickness study, its quick version. The first run is killed after SECONDS (1), each later one a second later: a case
# that takes longer than a run would never end.
set -euo pipefail

after=${1:-1}
gelpad=$(realpath "${2:-target/release/gelpad}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$gelpad" study thickness --quick --out "$work/whole" >/dev/null 2>&1
kills=0
# Within a shell of its own (`exit` keeps it one), or bash would tell of every kill.
until (timeout --signal=KILL "$after" "$gelpad" study thickness --quick --out "$work/killed"; exit) >/dev/null 2>&1; do
  kills=$((kills + 1)) after=$((after + 1))
done 2>/dev/null
[ "$kills" -gt 0 ] || { echo "it came to its end within $after s" >&2; exit 1; }
diff -r "$work/whole" "$work/killed"
echo "killed $kills times: $(find "$work/whole" -type f | wc -l) files, each the same as an unbroken run's"
