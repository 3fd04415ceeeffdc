#!/usr/bin/env bash
# Makes the Debian package and the tar.gz for other systems in target/packages: gelpad with gamepads, udev rule, desktop entry, icon,
# completions, man pages and the schema of profiles. Needs libudev-dev and pkg-config.
# Usage: scripts/package-deb.sh [GELPAD]        GELPAD: a program that was built already
set -euo pipefail
. "$(dirname "$0")/package-files.sh"
binary=${1:-}
maintainer=${GELPAD_MAINTAINER:-$(git log -1 --format="%an <%ae>")}
[ -d "$generated" ] || generate
if [ -z "$binary" ]; then
  RUSTFLAGS="$release_flags" CARGO_TARGET_DIR=$PWD/target/release-linux PKG_CONFIG=pkg-config \
    cargo build --quiet --release --locked --features gilrs
  binary=$PWD/target/release-linux/release/gelpad
fi
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
root=$stage/root
fill_prefix "$root/usr" "$binary"

doc=$root/usr/share/doc/gelpad
install -d "$doc" "$root/DEBIAN"
install -m644 README.md docs/glossary.md docs/profiles.md docs/recordings.md docs/accessibility.md docs/wire.md "$doc"
gzip -9n <CHANGELOG.md >"$doc/CHANGELOG.md.gz"
{
  printf 'gelpad (%s) unstable; urgency=medium\n\n' "$version"
  printf '  * See CHANGELOG.md.gz.\n\n'
  printf ' -- %s  %s\n' "$maintainer" "$(date -u -R -d "@$SOURCE_DATE_EPOCH")"
} | gzip -9n >"$doc/changelog.gz"
{
  echo "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/"
  echo "Upstream-Name: gelpad"
  echo
  echo "Files: *"
  echo "Copyright: $(sed -n 's/^Copyright (c) //p' LICENSE-MIT | head -1)"
  echo "License: Expat or Apache-2.0"
  echo
  echo "License: Expat"
  sed -e '1,/^$/d' -e '/^Copyright/d' LICENSE-MIT | sed -e 's/^$/./' -e 's/^/ /'
  echo
  echo "License: Apache-2.0"
  echo " On Debian systems, the text is in /usr/share/common-licenses/Apache-2.0."
} >"$doc/copyright"

# Libraries that the program is linked to, from Debian's own tool; those of the window are opened when it starts.
mkdir "$stage/debian"
echo "Source: gelpad" >"$stage/debian/control"
linked=$(cd "$stage" && dpkg-shlibdeps -O --ignore-missing-info "$root/usr/bin/gelpad" | sed 's/^shlibs:Depends=//')
window="libx11-6, libx11-xcb1, libxcursor1, libxi6, libxkbcommon0, libxkbcommon-x11-0, libgl1, libegl1, libgl1-mesa-dri"
cat >"$root/DEBIAN/control" <<END
Package: gelpad
Version: $version
Architecture: $(dpkg --print-architecture)
Maintainer: $maintainer
Installed-Size: $(du -sk "$root/usr" | cut -f1)
Depends: $linked, $window
Recommends: libwayland-client0, libwayland-egl1, udev
Section: utils
Priority: optional
Description: play games on a soft sheet of hydrogel
 gelpad turns touches on a pad that is read by electrical impedance
 tomography into keys and gamepad events: the length of a press is the
 height of the jump. A simulated pad is built in.
 .
 The package lets the logged-in user create virtual gamepads.
END
for script in postinst postrm; do
  cat >"$root/DEBIAN/$script" <<'END'
#!/bin/sh
set -e
# The rule takes effect at once where udev runs.
if [ -S /run/udev/control ] && command -v udevadm >/dev/null; then
  udevadm control --reload || true
  udevadm trigger --subsystem-match=misc || true
fi
END
  chmod 755 "$root/DEBIAN/$script"
done
(cd "$root" && find usr -type f -print0 | sort -z | xargs -0 md5sum >DEBIAN/md5sums)
find "$root" -type d -exec chmod 755 {} +
package=$out/gelpad_${version}_$(dpkg --print-architecture).deb
dpkg-deb --root-owner-group --build -Zxz "$root" "$package" >/dev/null

# The same files for other systems, with a script that copies them.
folder=gelpad-$version-linux-$(uname -m)
mkdir -p "$stage/tar/$folder"
cp -a "$root/usr" "$stage/tar/$folder/files"
rm -rf "$stage/tar/$folder/files/share/doc"
install -m755 packaging/linux/install.sh "$stage/tar/$folder/install.sh"
install -m644 README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$stage/tar/$folder"
tar --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" -C "$stage/tar" -c "$folder" |
  gzip -9n >"$out/$folder.tar.gz"
ls -l "$package" "$out/$folder.tar.gz" | awk '{ print $9, $5, "bytes" }'
