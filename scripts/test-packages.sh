#!/usr/bin/env bash
# Tests the packages with programs that were built already: lintian, metadata, installation and removal in a bare Debian 12 where the window opens,
# the tar.gz, and on Windows (wine) the zip and the installer. Needs root, debootstrap, lintian, appstream, desktop-file-utils, nsis, zip,
# xvfb and xdotool.
#
#   scripts/test-packages.sh GELPAD [GELPAD.EXE]        GELPAD: built with gamepads
set -euo pipefail
gelpad=$(realpath "$1")
exe=${2:+$(realpath "$2")}
. "$(dirname "$0")/package-files.sh"
work=$(mktemp -d)
started=()
mounted=()
end() {
  exec 2>/dev/null
  kill "${started[@]}" || true
  for folder in "${mounted[@]}"; do umount -l "$folder" || true; done
  [ ! -e "$work/wine" ] || WINEPREFIX=$work/wine wineserver64 -k || true
  rm -rf --one-file-system "$work"
}
trap end EXIT
PATH=$PATH:/usr/lib/wine
step() { printf -- '-- %s\n' "$*"; }

step "packages"
# Without the variables of a release, of which a crate depends on one: nothing is compiled again, here or by the tests after this.
(unset SOURCE_DATE_EPOCH GELPAD_COMMIT && generate)
strip -o "$work/gelpad" "$gelpad"
scripts/package-deb.sh "$work/gelpad"
deb=$(echo "$out/gelpad_${version}"_*.deb)
desktop-file-validate packaging/linux/org.gelpad.gelpad.desktop
dpkg-deb --fsys-tarfile "$deb" | tar -xO ./usr/share/metainfo/org.gelpad.gelpad.metainfo.xml >"$work/metainfo.xml"
appstreamcli validate --no-net "$work/metainfo.xml" >"$work/appstream" || { cat "$work/appstream"; exit 1; }
lintian --fail-on error "$deb" >"$work/lintian" || { cat "$work/lintian"; exit 1; }
echo "   lintian: no errors, $(grep -c '^W' "$work/lintian" || true) warnings"

step "a bare Debian 12"
# Kept between runs: half a minute of downloads.
bare=$PWD/target/bare-debian.tar
if [ ! -e "$bare" ]; then
  debootstrap --variant=minbase bookworm "$work/new" >/dev/null
  tar -C "$work/new" -cf "$bare" .
  rm -rf "$work/new"
fi
root=$work/root
mkdir "$root"
tar -C "$root" -xpf "$bare"
cp /etc/resolv.conf "$root/etc/resolv.conf"
# The same sources as here, and only those.
rm -f "$root"/etc/apt/sources.list "$root"/etc/apt/sources.list.d/*
for list in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
  [ ! -e "$list" ] || install -D "$list" "$root$list"
done
[ ! -d /etc/apt/apt.conf.d ] || cp -n /etc/apt/apt.conf.d/*proxy* "$root/etc/apt/apt.conf.d/" 2>/dev/null || true
mount -t proc proc "$root/proc"
mounted+=("$root/proc")
cp "$deb" "$root/gelpad.deb"
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive DISPLAY="${DISPLAY:-}" "$@"; }
inside apt-get -qq update
inside apt-get -qq install -y --no-install-recommends /gelpad.deb >/dev/null 2>&1
inside gelpad --version
inside gelpad profile list | head -2
[ -e "$root/usr/lib/udev/rules.d/70-gelpad.rules" ]
# There is no device to play through here.
(inside gelpad doctor 2>/dev/null || true) | grep "installed from"

step "its window"
Xvfb -displayfd 3 -noreset -nolisten tcp -screen 0 1280x1024x24 3>"$work/display" 2>/dev/null &
started+=($!)
until [ -s "$work/display" ]; do sleep 0.1; done
export DISPLAY=:$(cat "$work/display")
mkdir -p "$root/tmp/.X11-unix"
mount --bind /tmp/.X11-unix "$root/tmp/.X11-unix"
mounted+=("$root/tmp/.X11-unix")
inside gelpad >/dev/null 2>"$work/window" &
started+=($!)
for _ in $(seq 120); do
  ! xdotool search --onlyvisible --name '^gelpad' >/dev/null 2>&1 || break
  sleep 0.5
done
xdotool search --onlyvisible --name '^gelpad' getwindowname || { cat "$work/window"; exit 1; }
kill "${started[-1]}"
wait "${started[-1]}" 2>/dev/null || true

step "its removal"
inside apt-get -qq purge -y gelpad >/dev/null 2>&1
left=$(find "$root/usr" "$root/etc" "$root/var/lib/dpkg/info" -name '*gelpad*')
[ -z "$left" ] || { echo "left: $left"; exit 1; }

step "the tar.gz"
tar -C "$work" -xzf "$out/gelpad-$version-linux-$(uname -m).tar.gz"
(cd "$work/gelpad-$version-linux-$(uname -m)" && GELPAD_RULES=$work/rules ./install.sh "$work/prefix")
"$work/prefix/bin/gelpad" --version
(cd "$work/gelpad-$version-linux-$(uname -m)" && GELPAD_RULES=$work/rules ./install.sh --remove "$work/prefix")
[ -z "$(find "$work/prefix" "$work/rules" -type f)" ]

[ -n "$exe" ] || exit 0
step "Windows: the zip in any folder, the installer and its removal"
x86_64-w64-mingw32-strip -o "$work/gelpad.exe" "$exe"
scripts/package-windows.sh "$work/gelpad.exe"
export WINEPREFIX=$work/wine WINEDEBUG=-all
wine64 wineboot --init >/dev/null 2>&1
mkdir "$work/any folder"
(cd "$work/any folder" && python3 -m zipfile -e "$out/gelpad-$version-windows-x86_64.zip" .)
scripts/run-in-wine.sh "$work/any folder/gelpad-$version-windows-x86_64/gelpad.exe" --version
wine64 "$out/gelpad-$version-windows-x86_64-setup.exe" /S >/dev/null 2>&1
installed=$(compgen -G "$WINEPREFIX/drive_c/users/*/AppData/Local/Programs/gelpad")
scripts/run-in-wine.sh "$installed/gelpad.exe" --version
find "$WINEPREFIX/drive_c" -name gelpad.lnk | grep -q .
# It copies itself and goes on in the background.
wine64 "$installed/uninstall.exe" /S >/dev/null 2>&1
for _ in $(seq 60); do
  [ -e "$installed" ] || break
  sleep 0.5
done
left=$(find "$WINEPREFIX/drive_c" -iname '*gelpad*' -not -path '*/AppData/Local/gelpad*' -not -path '*/AppData/Roaming/gelpad*')
[ -z "$left" ] || { echo "left: $left"; exit 1; }
echo "   installed, run and removed"
