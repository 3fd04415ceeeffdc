#!/bin/sh
# Installs gelpad: sudo ./install.sh [PREFIX]             /usr/local by default
# Removes it:      sudo ./install.sh --remove [PREFIX]
set -eu
cd "$(dirname "$0")"
remove=no
if [ "${1:-}" = --remove ]; then
  remove=yes
  shift
fi
prefix=${1:-/usr/local}
# udev reads rules from here only.
rules=${GELPAD_RULES:-/etc/udev/rules.d}
rule=lib/udev/rules.d/70-gelpad.rules

(cd files && find . -type f) | sed 's|^\./||' | while read -r file; do
  to=$prefix/$file
  [ "$file" != "$rule" ] || to=$rules/70-gelpad.rules
  if [ "$remove" = yes ]; then
    rm -f "$to"
  else
    mkdir -p "$(dirname "$to")"
    cp "files/$file" "$to"
  fi
done
if [ -S /run/udev/control ] && command -v udevadm >/dev/null; then
  udevadm control --reload || true
  udevadm trigger --subsystem-match=misc || true
fi
if [ "$remove" = yes ]; then
  echo "gelpad was removed from $prefix"
else
  echo "gelpad was installed to $prefix; it needs libudev, and for its window libX11, libxkbcommon and OpenGL"
fi
