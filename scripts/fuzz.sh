#!/usr/bin/env bash
# Fuzzes every decoder: each wire format, recordings, files of frames. A line for each: inputs, inputs a second, the most
# memory, the slowest input. Ends with 1 if one failed; what failed and the whole output lie in target/fuzz, as do the inputs
# that led further, from which the next run begins. Needs cargo-fuzz (`cargo install cargo-fuzz`).
#
#   scripts/fuzz.sh [INPUTS] [NAME...]      10000000 inputs of each by default, as many at a time as there are cores:
#                                           half an hour on two
#   scripts/fuzz.sh 1000000 path reload     the slow ones, only where they are named: an engine plays each input (`path`: a
#                                           board's bytes up to its keys; `reload`: a profile saved while a key is held)
#   scripts/fuzz.sh 1000000 profile         profiles alone
set -euo pipefail
cd "$(dirname "$0")/.."

inputs=${1:-10000000}
shift || true
names=("$@")
[ ${#names[@]} -gt 0 ] || names=(wire:auto wire:gelpad wire:sciospec wire:openeit wire:request wire:square wire:lines
  recording files)

work=$PWD/target/fuzz
mkdir -p "$work"
# Without a sanitizer, which a stable compiler has not: there is no unsafe code here.
export RUSTC_BOOTSTRAP=1
for target in $(printf '%s\n' "${names[@]}" | sed 's/:.*//' | sort -u); do
  # Comparisons of an engine's numbers say nothing about its inputs, and tracing them takes more than half of its time.
  case $target in
    path | reload) options=(--no-trace-compares --target-dir "$work/build-engine") ;;
    *) options=(--target-dir "$work/build") ;;
  esac
  (cd fuzz && cargo fuzz build -s none "${options[@]}" "$target")
  ln -sf "$(find "${options[-1]}" -path "*/release/$target" -type f | head -1)" "$work/$target.run"
done

fuzz() {
  local name=$1 inputs=$2 target=${1%%:*} format=${1#*:}
  local folder=$work/${name/:/-}
  mkdir -p "$folder/corpus"
  # Files that are written ten thousand times a second: in memory where that can be.
  TMPDIR=$(mktemp -d -p "$([ -w /dev/shm ] && echo /dev/shm || echo "$folder")")
  export TMPDIR
  local options=("$folder/corpus")
  case $target in
    wire) options+=(-max_len=600 "-dict=fuzz/wire.dict") ;;
    files) options+=(-max_len=1024 "-dict=fuzz/files.dict") ;;
    recording) options+=(-max_len=6144) ;;
    path) options+=(-max_len=128) ;;
    profile | reload) options+=(profiles users) ;;
  esac
  [ "$format" = "$target" ] || export GELPAD_FUZZ_FORMAT=$format
  local told=clean
  "$work/$target.run" "${options[@]}" "-runs=$inputs" "-artifact_prefix=$folder/" -rss_limit_mb=1024 \
    -timeout=10 -print_final_stats=1 >"$folder/output" 2>&1 || told="FAILED: see $folder/output"
  rm -rf "$TMPDIR"
  figure() { sed -n "s/^stat::$1: *//p" "$folder/output"; }
  printf '%-14s %9s inputs, %6s/s, %3s MB at most, slowest %s s: %s\n' "$name" "$(figure number_of_executed_units)" \
    "$(figure average_exec_per_sec)" "$(figure peak_rss_mb)" "$(figure slowest_unit_time_sec)" "$told"
  [ "$told" = clean ]
}
export -f fuzz
export work
printf '%s\0' "${names[@]}" | xargs -0 -P "$(nproc)" -I{} bash -euo pipefail -c 'fuzz "$1" "$2"' fuzz {} "$inputs"
