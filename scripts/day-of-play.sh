#!/usr/bin/env bash
# Plays a day on simulated pads: several pads, boards that disturb in turn, hands of all kinds. Prints what was missed, what was
# made up and what stuck, by cause. Ends with 1 if a touch without a finger lasted longer than 50 ms on a pad that only one
# finger plays, or if anything was down half a second after a lift.
#
#   scripts/day-of-play.sh [HOURS] [GELPAD] [FIRST_SEED]      24 hours by default: a quarter of an hour on two cores
set -euo pipefail
hours=${1:-24}
gelpad=$(realpath "${2:-target/release/gelpad}")
seed=${3:-101}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
pads=(edinburgh-lattice edinburgh-solid)
causes=(gain:60 drive:50 spikes:0.3 surge:0.3 gain-step:0.2 mains:0.003 noisy-channel:0.1 dead-channel lost-pair \
  repeated-start:10 bad-frame:10 garbage-start adc:12 spikes:5 surge:-0.5 gain:60,spikes:0.3)

seconds=0
round=0
while [ "$seconds" -lt $((hours * 3600)) ]; do
  pad=${pads[round % ${#pads[@]}]}
  cause=${causes[round % ${#causes[@]}]}
  snr=60
  [ "$cause" = adc:12 ] && snr=70
  "$gelpad" accuracy --real --pad "$pad" --seed $((seed + round)) --disturb "$cause" --snr "$snr" \
    --out "$folder/$round" >/dev/null 2>>"$folder/log" || { cat "$folder/log" >&2; exit 1; }
  if [ $((round % 8)) = 7 ]; then
    "$gelpad" accuracy --real --pad "$pad" --seed $((seed + round)) --only "500 ms after the lift" \
      --out "$folder/$round-hands" >/dev/null 2>>"$folder/log" || { cat "$folder/log" >&2; exit 1; }
  fi
  played=$(python3 -c '
import json, sys
print(int(sum(c["seconds"] for c in json.load(open(sys.argv[1]))["conditions"])))' "$folder/$round/real.json")
  seconds=$((seconds + played))
  round=$((round + 1))
done

python3 - "$folder" <<'PYTHON'
import collections, glob, json, sys

rows = collections.defaultdict(lambda: [0.0, 0, 0, 0, 0.0, 0])
for path in glob.glob(sys.argv[1] + "/*/real.json"):
    for c in json.load(open(path))["conditions"]:
        row = rows[(c["disturbances"] or "hands", c["name"])]
        row[0] += c["seconds"] / 3600
        row[1] += c["missed"]["n"]
        row[2] += c["missed"]["hits"]
        row[3] += c["false_touches"]
        row[4] = max(row[4], c["longest_ms"])
        row[5] += c["stuck"]
print(f"{'cause':<22} {'who':<36} {'hours':>6} {'fingers':>8} {'missed':>7} {'false':>6} {'longest ms':>11} {'stuck':>6}")
for (cause, who), row in sorted(rows.items()):
    print(f"{cause:<22} {who:<36} {row[0]:>6.1f} {row[1]:>8} {row[2]:>7} {row[3]:>6} {row[4]:>11.0f} {row[5]:>6}")
stuck = sum(row[5] for row in rows.values())
long = [key for key, row in rows.items() if row[4] > 50 and key[0] != "hands"]
print(f"{sum(row[0] for row in rows.values()):.1f} hours played; {stuck} stuck; longer than 50 ms: {long or 'none'}")
sys.exit(1 if stuck or long else 0)
PYTHON
