#!/usr/bin/env bash
# Builds gelpad for Windows and tests it under wine, then builds the packages of Linux and Windows and tries them.
# Installs by apt what it needs. Called by .ci/run.
set -euo pipefail
cd "$(dirname "$0")/.."
gelpad=target/debug/gelpad

apt=(apt-get -qq -o DPkg::Lock::Timeout=300)
[ "$(id -u)" = 0 ] || apt=(sudo "${apt[@]}")
missing=()
for package in xvfb xdotool imagemagick debootstrap lintian appstream desktop-file-utils nsis zip socat libudev-dev pkg-config; do
  dpkg-query -Wf '${db:Status-Abbrev}' "$package" 2>/dev/null | grep -q '^ii' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  "${apt[@]}" update
  DEBIAN_FRONTEND=noninteractive "${apt[@]}" install -y --no-install-recommends "${missing[@]}" >/dev/null
fi

# As .ci/run has compiled them: the programs are linked again, no more.
PKG_CONFIG=pkg-config cargo test --quiet --no-run --locked --features gilrs --test guest --test doctor
cp $gelpad target/gelpad-with-gamepads
cargo test --quiet --no-run --locked --test cli

printf '\n== Windows, under wine\n'
scripts/test-windows.sh $gelpad
printf '\n== packages\n'
scripts/test-packages.sh target/gelpad-with-gamepads target/windows/x86_64-pc-windows-gnu/debug/gelpad.exe
size=$(cargo package --quiet --locked --no-verify --allow-dirty >/dev/null && stat -c %s target/package/gelpad-*.crate)
[ "$size" -le 10000000 ] || { echo "the crate has $size bytes, more than 10 MB" >&2; exit 1; }
