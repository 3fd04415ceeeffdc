#!/bin/sh
# Places two measured skins by their voltages: random splits, five seeds, `gelpad calibrate --evaluate` on each.
#   scripts/hydrogel-presses.sh [SEEDS] [SIZES]        defaults: "1 2 3 4 5" and "50 500 2000"
# SPREAD=1 with sizes up to 1000: each next press to learn from is the one of the first 1000 shuffled presses that is farthest from all chosen
# so far. The test presses are those after the first 1000.
# The data (no licence: not part of gelpad) is read from $GELPAD_DATA/hydrogel-presses, else ../shared/data; GELPAD names the
# program to run. Needs awk and nothing else. Prints a JSON line a run, then the mean error of each skin and size.
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
data=${GELPAD_DATA:-$here/../shared/data}/hydrogel-presses
gelpad=${GELPAD:-$here/target/release/gelpad}
seeds=${1:-1 2 3 4 5}
sizes=${2:-50 500 2000}
for size in $sizes; do
    if [ -n "${SPREAD:-}" ] && [ "$size" -gt 1000 ]; then
        echo "$0: SPREAD=1 chooses from 1000 presses: $size is too many" >&2
        exit 1
    fi
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for skin in noPattern parallel; do
    for size in $sizes; do
        for seed in $seeds; do
            # Fisher-Yates with awk's own generator: the same seed gives the same split. Metres become millimetres.
            paste -d, "$data/out_$skin.csv" "$data/inp_$skin.csv" | awk -F, -v OFS=, -v seed="$seed" -v size="$size" -v spread="${SPREAD:-}" \
                -v train="$work/train.csv" -v test="$work/test.csv" '
                # Brings the presses that are farthest from those before them to the front.
                function spread_out(  i, k, far, d, least, t) {
                    for (i = 1; i <= pool; i++) { split(row[i], v, ","); px[i] = v[1]; py[i] = v[2]; least[i] = 1e9 }
                    for (k = 1; k < size; k++) {
                        far = k + 1
                        for (i = k + 1; i <= pool; i++) {
                            d = (px[i] - px[k]) ^ 2 + (py[i] - py[k]) ^ 2
                            if (d < least[i]) least[i] = d
                            if (least[i] > least[far]) far = i
                        }
                        i = k + 1
                        t = row[i]; row[i] = row[far]; row[far] = t
                        t = px[i]; px[i] = px[far]; px[far] = t
                        t = py[i]; py[i] = py[far]; py[far] = t
                        t = least[i]; least[i] = least[far]; least[far] = t
                    }
                }
                { row[NR] = $0 }
                END {
                    header = "x_mm,y_mm"
                    for (d = 0; d < NF - 3; d++) header = header ",d" d
                    print header > train
                    print header > test
                    srand(seed * 1000 + 7)
                    for (i = NR; i > 1; i--) { j = 1 + int(rand() * i); t = row[i]; row[i] = row[j]; row[j] = t }
                    pool = spread ? 1000 : size
                    if (spread) spread_out()
                    for (i = 1; i <= NR; i++) {
                        if (i > size && i <= pool) continue
                        n = split(row[i], v, ",")
                        line = sprintf("%.6f,%.6f", v[1] * 1000, v[2] * 1000)
                        for (d = 4; d <= n; d++) line = line "," v[d]
                        print line > (i <= size ? train : test)
                    }
                }'
            line=$("$gelpad" calibrate --presses "$work/train.csv" --evaluate "$work/test.csv")
            echo "$skin $size seed $seed $line"
        done
    done
done | tee "$work/runs"
awk '{ match($0, /"mean_mm":[0-9.]+/); sum[$1 " " $2] += substr($0, RSTART + 10, RLENGTH - 10); n[$1 " " $2]++ }
     END { for (k in sum) printf "%s presses: mean error %.3f mm over %d splits\n", k, sum[k] / n[k], n[k] }' "$work/runs" | sort
