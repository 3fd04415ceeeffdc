#!/usr/bin/env bash
# Kills a study again and again until it comes to its end, and compares what it wrote with an unbroken run's.
#
#   scripts/kill-a-study.sh [SECONDS [GELPAD]]
#
# The thickness study, its quick version; each run is killed after SECONDS (15).
set -euo pipefail

after=${1:-15}
gelpad=$(realpath "${2:-target/release/gelpad}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$gelpad" study thickness --quick --out "$work/whole" 2>/dev/null
kills=0
until timeout --signal=KILL "$after" "$gelpad" study thickness --quick --out "$work/killed" >/dev/null 2>&1; do
  kills=$((kills + 1))
  # A case that takes longer than that would never end.
  [ "$kills" -lt 20 ] || { echo "killed $kills times, and no end: give it more than $after s" >&2; exit 1; }
done
[ "$kills" -gt 0 ] || { echo "it came to its end within $after s: give it less" >&2; exit 1; }
diff -r "$work/whole" "$work/killed"
echo "killed $kills times: $(find "$work/whole" -type f | wc -l) files, each the same as an unbroken run's"
