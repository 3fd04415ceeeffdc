#!/usr/bin/env bash
# From a press of the pad to its key, over a pseudo-terminal at 115,200 baud with OpenEIT's text (a quarter of a second a frame):
# medians and 95th percentiles, in parts and frame by frame, of the same presses at the same time.
#
#   scripts/press-to-key.sh [PRESSES]      40 by default: forty seconds
set -euo pipefail
cd "$(dirname "$0")/.."
GELPAD_PRESSES=${1:-40} cargo test --quiet --test parts a_press_reaches -- --nocapture | grep -E "frame by frame|in parts"
