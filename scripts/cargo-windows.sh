#!/usr/bin/env bash
# Runs cargo for Windows (x86-64), with the standard library built from source; `run` and `test` run under wine.
# The list of build-std is one and the same for all commands, so that everything is compiled once.
# Usage: scripts/cargo-windows.sh CARGO-COMMAND [ARGUMENTS]        for example: scripts/cargo-windows.sh test --lib
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/windows-toolchain.sh
folder=$PWD/target/windows-toolchain
export RUSTC=$folder/bin/rustc RUSTC_BOOTSTRAP=1
# For releases.
[ -z "${GELPAD_REPRODUCIBLE:-}" ] || export PATH=$PWD/scripts/windows-tools:$PATH
export CARGO_TARGET_X86_64_PC_WINDOWS_GNU_LINKER=x86_64-w64-mingw32-gcc
export CARGO_TARGET_X86_64_PC_WINDOWS_GNU_RUNNER=$PWD/scripts/run-in-wine.sh
export CC_x86_64_pc_windows_gnu=x86_64-w64-mingw32-gcc AR_x86_64_pc_windows_gnu=x86_64-w64-mingw32-ar
export CARGO_TARGET_DIR=${GELPAD_WINDOWS_TARGET:-$PWD/target/windows}
command=$1
shift
exec cargo --config scripts/windows-tests.toml "$command" -Z build-std=std,panic_unwind,test --target x86_64-pc-windows-gnu --locked "$@"
