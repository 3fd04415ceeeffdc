#!/usr/bin/env bash
# Runs a Windows program under wine, in a folder of its own for wine's settings.
# Usage: scripts/run-in-wine.sh PROGRAM.exe [ARGUMENTS]
set -euo pipefail
root=$(realpath "$(dirname "$0")/..")
export WINEPREFIX=${WINEPREFIX:-$root/target/wine} WINEDEBUG=${WINEDEBUG:--all} WINEDLLOVERRIDES="mscoree,mshtml="
# The library that wine 8 lacks is found here.
WINEPATH=Z:$(tr / '\\' <<<"$root/target/windows-toolchain/wine-libraries")
export WINEPATH GELPAD_UNDER_WINE=1
PATH=$PATH:/usr/lib/wine exec wine64 "$@"
