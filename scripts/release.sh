#!/usr/bin/env bash
# Makes a release in target/packages: the Debian package, the tar.gz, the Windows zip and installer, the section of the changelog, a bill
# of materials, and check sums. With --twice everything is built a second time, and the bytes are compared.
# Usage: scripts/release.sh VERSION [--twice]
set -euo pipefail
wanted=${1:?the version is missing: scripts/release.sh 0.1.0}
twice=${2:-}
. "$(dirname "$0")/package-files.sh"
[ "$wanted" = "$version" ] || { echo "Cargo.toml says $version, not $wanted" >&2; exit 1; }
[ -z "$(git status --porcelain)" ] || { echo "there are changes that are not committed" >&2; exit 1; }

make_all() {
  generate
  scripts/package-deb.sh
  scripts/package-windows.sh
  # The section of this version, or what is not released yet.
  awk -v version="$version" '/^## / { on = index($0, version) || (!seen && /Unreleased/); seen = seen || on } on' CHANGELOG.md \
    >"$out/CHANGES-$version.md"
  # Every crate of both programs, with its licence.
  for target in x86_64-unknown-linux-gnu x86_64-pc-windows-gnu; do
    cargo metadata --locked --format-version 1 --filter-platform $target --features gilrs,vigem |
      python3 scripts/bill-of-materials.py "$version" "$commit" $target >"$out/gelpad-$version-$target.cdx.json"
  done
  (cd "$out" && find . -maxdepth 1 -type f ! -name SHA256SUMS -printf '%P\n' | sort | xargs sha256sum >SHA256SUMS)
}

# What an earlier build left must not be compared with a build from nothing.
[ "$twice" != --twice ] || rm -rf target/release-linux/release target/release-windows/x86_64-pc-windows-gnu/release
rm -rf "$out"
mkdir -p "$out"
make_all
if [ "$twice" = --twice ]; then
  cp "$out/SHA256SUMS" target/first-sums
  rm -rf "$out" target/release-linux/release target/release-windows/x86_64-pc-windows-gnu/release
  mkdir -p "$out"
  make_all
  diff target/first-sums "$out/SHA256SUMS"
  echo "built twice, the same bytes"
fi
cat "$out/SHA256SUMS"
