#!/usr/bin/env bash
# The full count of tests/kills.rs: kills gelpad with keys held, a thousand times, and reports how long they stayed down. Needs the
# Debian package xvfb.
#
#   scripts/kill-a-thousand.sh [KILLS]      1000 by default: half an hour
set -euo pipefail
cd "$(dirname "$0")/.."
GELPAD_TEST_ALL=1 GELPAD_KILLS=${1:-1000} cargo test --quiet --test kills killed -- --nocapture
