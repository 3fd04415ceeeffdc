#!/usr/bin/env bash
# Prepares a compiler for Windows (x86-64) in target/windows-toolchain, from Debian's packages and without rustup targets: Debian's Rust, the
# source of its standard library, mingw as the linker, and wine to run the result. Done once; later calls return at once.
# Usage: scripts/windows-toolchain.sh
set -euo pipefail
cd "$(dirname "$0")/.."
folder=$PWD/target/windows-toolchain
root=$folder/root
version=1.96

packages=(gcc-mingw-w64-x86-64-posix wine64 wine)
missing=()
for package in "${packages[@]}"; do
  dpkg-query -Wf '${db:Status-Abbrev}' "$package" 2>/dev/null | grep -q '^ii' || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
  apt=(apt-get -qq -o DPkg::Lock::Timeout=300)
  [ "$(id -u)" = 0 ] || apt=(sudo "${apt[@]}")
  "${apt[@]}" update
  DEBIAN_FRONTEND=noninteractive "${apt[@]}" install -y --no-install-recommends "${missing[@]}" >/dev/null
fi
[ ! -e "$folder/ready" ] || exit 0

# The packages conflict with other toolchains, so they are unpacked, not installed. Compiler and source must be of one version.
mkdir -p "$folder/packages" "$folder/bin"
(
  cd "$folder/packages"
  apt-get -qq download rustc-web "libstd-rust-web-$version" libstd-rust-web-dev rust-web-src libllvm22
)
for package in "$folder"/packages/*.deb; do
  dpkg -x "$package" "$root"
done
source=$(echo "$root"/usr/src/rustc-"$version"*)
mkdir -p "$root/usr/lib/rustlib/src"
ln -sfn "$source" "$root/usr/lib/rustlib/src/rust"
cat >"$folder/bin/rustc" <<END
#!/bin/sh
LD_LIBRARY_PATH=$root/usr/lib/x86_64-linux-gnu exec $root/usr/bin/rustc "\$@"
END
chmod +x "$folder/bin/rustc"

# The first and the last object of every Windows program.
objects=$root/usr/lib/rustlib/x86_64-pc-windows-gnu/lib
mkdir -p "$objects"
for name in rsbegin rsend; do
  RUSTC_BOOTSTRAP=1 "$folder/bin/rustc" --target x86_64-pc-windows-gnu --emit=obj -o "$objects/$name.o" \
    "$source/library/rtstartup/$name.rs"
done

# wine 8 lacks this library, which Rust's standard library needs for random numbers; Windows has it.
cat >"$folder/bcryptprimitives.c" <<'END'
#include <windows.h>
#include <ntsecapi.h>
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE bytes, SIZE_T count) { return RtlGenRandom(bytes, (ULONG)count); }
END
mkdir -p "$folder/wine-libraries"
x86_64-w64-mingw32-gcc -shared -O2 -o "$folder/wine-libraries/bcryptprimitives.dll" "$folder/bcryptprimitives.c" -ladvapi32
touch "$folder/ready"
