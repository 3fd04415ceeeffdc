#!/usr/bin/env bash
# Plays random presses of 34 to 200 ms into SuperTux and checks that the game saw each of them once and none is down at the end.
# Two fingers press at once: jump, and right or left. The same into fceux: GELPAD_PRESSES=10000 cargo test --test game presses
# Needs the Debian packages xvfb, xdotool, supertux and python3; uses its own virtual display.
#
#   scripts/presses-in-games.sh [PRESSES]      200 by default: half a minute; 10000 take twenty minutes
set -euo pipefail
presses=${1:-200}
source "$(dirname "$0")/stage.sh"
stage 800x600
flat_level
supertux "$folder/flat.stl"
python3 - "$presses" "$folder/touches.txt" <<'PYTHON'
import random, sys

random.seed(1)
events, left = [], int(sys.argv[1])
fingers = [(1, ["80 50"], left - left // 2), (2, ["37 55", "13 55"], left // 2)]
for finger, places, count in fingers:
    t = 1000
    for press in range(count):
        events.append((t, f"down {finger} {places[press % len(places)]}"))
        t += random.randint(34, 200)
        events.append((t, f"up {finger}"))
        t += random.randint(50, 200)
events.sort()
with open(sys.argv[2], "w") as script:
    for t, event in events:
        script.write(f"t:{t} {event}\n")
    script.write(f"t:{events[-1][0] + 500} end\n")
PYTHON
play supertux
sleep 2
kill "$game"
keys_seen | tee "$folder/seen" | python3 -c '
import sys

wanted = {"jump": int(sys.argv[1]) - int(sys.argv[1]) // 2}
pairs = int(sys.argv[1]) // 2
wanted["right"], wanted["left"] = pairs - pairs // 2, pairs // 2
wrong = 0
for line in sys.stdin:
    key, *steps = line.split()
    steps = [int(step) for step in steps]
    if key not in wanted:
        assert not steps, f"{key} was seen, and never pressed"
        continue
    shown = f"shortest {min(steps)}, longest {max(steps)} steps" if steps else "none"
    print(f"{key:5} pressed {wanted[key]}, seen {len(steps)}: {shown}")
    wrong += len(steps) != wanted[key] or max(steps) > 20
sys.exit(bool(wrong))
' "$presses"
