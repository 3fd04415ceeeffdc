#!/bin/sh
# Locates two and three touches on two measured skins, with maps learned from single presses: the changes of measured presses of
# the test split are added, 100 sets for each class of least distance, and `gelpad calibrate --evaluate` locates them.
#   scripts/hydrogel-touches.sh [SEEDS] [SIZE] [COUNT]        defaults: "1 2 3 4 5", 500 and 2
# The splits are those of scripts/hydrogel-presses.sh. The data (no licence: not part of gelpad) is read from
# $GELPAD_DATA/hydrogel-presses, else ../shared/data; GELPAD names the program to run. Needs awk and nothing else. Prints a JSON
# line a run, then the mean error of each skin and class. A class that a skin is too small for is left out.
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
data=${GELPAD_DATA:-$here/../shared/data}/hydrogel-presses
gelpad=${GELPAD:-$here/target/release/gelpad}
seeds=${1:-1 2 3 4 5}
size=${2:-500}
count=${3:-2}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for skin in noPattern parallel; do
    for seed in $seeds; do
        for class in "15 30" "30 50" "50 80" "80 200"; do
            paste -d, "$data/out_$skin.csv" "$data/inp_$skin.csv" | awk -F, -v OFS=, -v seed="$seed" -v size="$size" \
                -v count="$count" -v class="$class" -v train="$work/train.csv" -v test="$work/test.csv" '
                { row[NR] = $0 }
                END {
                    channels = NF - 3
                    split(class, limit, " ")
                    header = "x_mm,y_mm"
                    several = header
                    for (k = 2; k <= count; k++) several = several ",x" k "_mm,y" k "_mm"
                    for (d = 0; d < channels; d++) { header = header ",d" d; several = several ",d" d }
                    print header > train
                    print several > test
                    srand(seed * 1000 + 7)
                    for (i = NR; i > 1; i--) { j = 1 + int(rand() * i); t = row[i]; row[i] = row[j]; row[j] = t }
                    for (i = 1; i <= size; i++) {
                        n = split(row[i], v, ",")
                        line = sprintf("%.6f,%.6f", v[1] * 1000, v[2] * 1000)
                        for (d = 4; d <= n; d++) line = line "," v[d]
                        print line > train
                    }
                    for (tries = 0; made < 100 && tries < 300000; tries++) {
                        least = 1e9
                        for (k = 1; k <= count; k++) {
                            set[k] = size + 1 + int(rand() * (NR - size))
                            split(row[set[k]], v, ",")
                            x[k] = v[1] * 1000
                            y[k] = v[2] * 1000
                            for (j = 1; j < k; j++) {
                                apart = sqrt((x[k] - x[j]) ^ 2 + (y[k] - y[j]) ^ 2)
                                if (apart < least) least = apart
                            }
                        }
                        if (least < limit[1] || least >= limit[2]) continue
                        made++
                        line = ""
                        for (k = 1; k <= count; k++) line = line (k > 1 ? "," : "") sprintf("%.6f,%.6f", x[k], y[k])
                        for (d = 4; d < 4 + channels; d++) sum[d] = 0
                        for (k = 1; k <= count; k++) {
                            split(row[set[k]], v, ",")
                            for (d = 4; d < 4 + channels; d++) sum[d] += v[d]
                        }
                        for (d = 4; d < 4 + channels; d++) line = line "," sum[d]
                        print line > test
                    }
                }'
            if [ "$(wc -l <"$work/test.csv")" -lt 101 ]; then
                continue
            fi
            line=$("$gelpad" calibrate --presses "$work/train.csv" --evaluate "$work/test.csv")
            echo "$skin ${class% *} seed $seed $line"
        done
    done
done | tee "$work/runs"
awk '{ match($0, /"mean_mm":[0-9.]+/); sum[$1 " " $2] += substr($0, RSTART + 10, RLENGTH - 10); n[$1 " " $2]++ }
     END { for (k in sum) printf "%s mm apart and more: mean error %.3f mm over %d splits\n", k, sum[k] / n[k], n[k] }' "$work/runs" | sort
