#!/usr/bin/env bash
# Plays conditions of `gelpad accuracy --real` on four new pads for each seed, and prints what all seeds together give: rows of
# docs/accuracy.md that four pads do not decide.
#
#   scripts/accuracy-over-seeds.sh NAME [FIRST] [LAST] [GELPAD]    seeds 21 to 40 by default: some three minutes for a row
set -euo pipefail
name=$1
first=${2:-21}
last=${3:-40}
gelpad=$(realpath "${4:-target/release/gelpad}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

for seed in $(seq "$first" "$last"); do
  "$gelpad" accuracy --real --only "$name" --seed "$seed" --out "$folder/$seed" >/dev/null 2>"$folder/log" || { cat "$folder/log" >&2; exit 1; }
done

python3 - "$folder" <<'PYTHON'
import glob, json, math, sys

def share(found):
    """A share in per cent with Wilson's 95 % interval."""
    hits, n = (sum(part[key] for part in found) for key in ("hits", "n"))
    if n == 0:
        return "-"
    z, p = 1.96, hits / n
    middle, half = p + z * z / (2 * n), z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    low, high = ((middle + side * half) / (1 + z * z / n) for side in (-1, 1))
    return f"{100 * p:.1f} % of {n} ({100 * max(low, 0):.1f} to {100 * high:.1f})"

def mean(found):
    n = sum(part["n"] for part in found)
    return f"{sum(part['mean'] * part['n'] for part in found if part['n']) / n:.3f} mm" if n else "-"

rows = {}
for path in glob.glob(sys.argv[1] + "/*/real.json"):
    for condition in json.load(open(path))["conditions"]:
        rows.setdefault(condition["name"], []).append(condition)
for name, of_seeds in rows.items():
    def get(key):
        return [condition[key] for condition in of_seeds]
    print(f"{name}, {len(of_seeds)} seeds")
    print(f"  missed    {share(get('missed'))}")
    print(f"  right     {share(get('counted_right'))}")
    print(f"  first     {mean(get('first_mm'))}, median of seeds' medians {sorted(part['median'] for part in get('first_mm'))[len(of_seeds) // 2]:.3f} mm")
    print(f"  held      {mean(get('last_mm'))}")
    print(f"  false     {sum(get('false_touches'))}, longest {max(get('longest_ms')):.0f} ms; stuck {sum(get('stuck'))}")
PYTHON
