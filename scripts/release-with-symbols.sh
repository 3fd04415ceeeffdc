#!/usr/bin/env bash
# Builds the release binary with its line tables in a separate file, gelpad.debug, which debuggers and `perf` find beside it.
# Needs objcopy (binutils).
#
#   scripts/release-with-symbols.sh
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --locked --config 'profile.release.strip="none"'
cd target/release
objcopy --only-keep-debug gelpad gelpad.debug
objcopy --strip-debug --add-gnu-debuglink=gelpad.debug gelpad
ls -l gelpad gelpad.debug
