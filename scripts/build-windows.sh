#!/usr/bin/env bash
# Builds gelpad.exe for Windows (x86-64) and prints its path.
# Usage: scripts/build-windows.sh [--release]
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/cargo-windows.sh build --quiet --features vigem --bin gelpad "$@"
profile=debug
[ "${1:-}" != --release ] || profile=release
exe=${GELPAD_WINDOWS_TARGET:-$PWD/target/windows}/x86_64-pc-windows-gnu/$profile/gelpad.exe
# It runs from any folder: every library that it names comes with Windows.
needed=$(x86_64-w64-mingw32-objdump -p "$exe" | sed -n 's/.*DLL Name: //p')
if grep -iE 'libgcc|libstdc|winpthread' <<<"$needed"; then
  echo "gelpad.exe needs the libraries above, which Windows does not have" >&2
  exit 1
fi
echo "$exe"
