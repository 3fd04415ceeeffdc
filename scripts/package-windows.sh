#!/usr/bin/env bash
# Makes the zip that runs from any folder and the installer for Windows in target/packages. Needs zip and nsis.
# Usage: scripts/package-windows.sh [GELPAD.EXE]        GELPAD.EXE: a program that was built already
set -euo pipefail
. "$(dirname "$0")/package-files.sh"
exe=${1:-}
[ -d "$generated" ] || generate
if [ -z "$exe" ]; then
  # A linker that writes no time into the program.
  exe=$(GELPAD_REPRODUCIBLE=1 RUSTFLAGS="$release_flags -C link-arg=-Wl,--no-insert-timestamp" GELPAD_WINDOWS_TARGET=$PWD/target/release-windows \
    scripts/build-windows.sh --release)
fi
stage=$(mktemp -d)
trap 'rm -rf "$stage"' EXIT
folder=gelpad-$version-windows-x86_64
mkdir "$stage/$folder"
install -m755 "$exe" "$stage/$folder/gelpad.exe"
install -m644 README.md CHANGELOG.md docs/windows.md "$generated/profile.schema.json" "$stage/$folder"
install -m644 "$generated/completions/_gelpad.ps1" "$stage/$folder/gelpad.ps1"
for license in MIT APACHE; do
  install -m644 "LICENSE-$license" "$stage/$folder/LICENSE-$license.txt"
done
find "$stage" -exec touch -h -d "@$SOURCE_DATE_EPOCH" {} +
(
  cd "$stage"
  rm -f "$out/$folder.zip"
  find "$folder" | sort | zip -q -X -9 "$out/$folder.zip" -@
)
makensis -V1 -DVERSION="$version" -DSOURCE="$stage/$folder" -DOUTPUT="$out/$folder-setup.exe" packaging/windows/gelpad.nsi
ls -l "$out/$folder.zip" "$out/$folder-setup.exe" | awk '{ print $9, $5, "bytes" }'
