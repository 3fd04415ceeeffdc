#!/usr/bin/env bash
# Endings of gelpad that an adversary would choose, drawn at random, and how many leave a key down: signals, crashes, watchers
# killed or stopped with it, displays that stall, storms of reloads, lost terminals, damaged recordings. Needs the Debian packages
# xvfb, sway, wev and tmux; the guest needs what scripts/run-in-guest.sh names.
#
#   scripts/adversary.sh [X11] [WAYLAND] [GUEST] [FLIPS] [CUTS] [SEED] [SIGNALS] [MUTATIONS]
#                                                       defaults: 1000 1000 100 500 200 1 30 100000
#
# 1000 endings on X11 take about half an hour; a sample of each kind is part of `cargo test`.
set -euo pipefail
cd "$(dirname "$0")/.."
x11=${1:-1000} wayland=${2:-1000} guest=${3:-100} flips=${4:-500} cuts=${5:-200} seed=${6:-1} signals=${7:-30} mutations=${8:-100000}
export GELPAD_TEST_ALL=1 RUST_BACKTRACE=0
status=0

# run WHAT COMMAND...: continues after a failure, which is reported at the end.
run() {
  printf '\n== %s\n' "$1"
  shift
  "$@" || status=1
}

if [ "$x11" -gt 0 ]; then
  run "$x11 endings on X11" env GELPAD_ENDINGS="$x11" GELPAD_SEED="$seed" \
    cargo test --quiet --locked --test kills endings -- --nocapture
fi
if [ "$signals" -gt 0 ]; then
  for trial in each_signal closed_pipes a_killed_terminal a_killed_shell a_killed_tmux; do
    run "$trial, $signals times each" env GELPAD_SIGNALS="$signals" \
      cargo test --quiet --locked --test kills "$trial" -- --nocapture
  done
fi
if [ "$wayland" -gt 0 ]; then
  run "$wayland endings on Wayland" env GELPAD_ENDINGS="$wayland" GELPAD_SEED="$seed" \
    cargo test --quiet --locked --test wayland endings -- --nocapture
fi
if [ "$guest" -gt 0 ]; then
  run "$guest endings with the kernel's devices" env GELPAD_GUEST_ENDINGS="$guest" \
    cargo test --quiet --locked --test kills guest -- --nocapture
fi
if [ "$flips" -gt 0 ] || [ "$cuts" -gt 0 ]; then
  run "$flips flipped bits and $cuts cuts of each of three recordings" env GELPAD_FLIPS="$flips" GELPAD_CUTS="$cuts" \
    cargo test --quiet --locked --test recording flips -- --nocapture
fi
if [ "$mutations" -gt 0 ]; then
  run "$mutations profiles with damaged texts" env GELPAD_MUTATIONS="$mutations" \
    cargo test --quiet --locked --lib no_text_of_a_user -- --nocapture
fi
exit "$status"
