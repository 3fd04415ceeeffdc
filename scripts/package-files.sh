# Sourced by the scripts that make packages. Sets:
#   version, commit, SOURCE_DATE_EPOCH (the time of the commit), out (target/packages), generated (completions, man pages, schema)
# and defines release_build TARGET-NAME CARGO-COMMAND...: a build of which a second one has the same bytes.
cd "$(dirname "${BASH_SOURCE[0]}")/.."
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
commit=$(git rev-parse --short=12 HEAD)
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
GELPAD_COMMIT=$commit
out=$PWD/target/packages
generated=$PWD/target/generated
export SOURCE_DATE_EPOCH GELPAD_COMMIT LC_ALL=C TZ=UTC
mkdir -p "$out"

# Paths of this computer are not part of the program.
release_flags="--remap-path-prefix=$PWD=gelpad --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"

generate() {
  rm -rf "$generated"
  cargo run --quiet --locked --example generate -- "$generated"
}

# Fills a folder with what Linux packages install below /usr.
fill_prefix() {
  local to=$1 binary=$2
  install -Dm755 "$binary" "$to/bin/gelpad"
  install -Dm644 udev/70-gelpad.rules "$to/lib/udev/rules.d/70-gelpad.rules"
  install -Dm644 packaging/linux/org.gelpad.gelpad.desktop -t "$to/share/applications"
  install -Dm644 packaging/org.gelpad.gelpad.svg -t "$to/share/icons/hicolor/scalable/apps"
  install -d "$to/share/metainfo"
  sed "s/@VERSION@/$version/; s/@DATE@/$(date -u -d "@$SOURCE_DATE_EPOCH" +%F)/" packaging/linux/org.gelpad.gelpad.metainfo.xml \
    >"$to/share/metainfo/org.gelpad.gelpad.metainfo.xml"
  install -Dm644 "$generated/completions/gelpad.bash" "$to/share/bash-completion/completions/gelpad"
  install -Dm644 "$generated/completions/_gelpad" -t "$to/share/zsh/vendor-completions"
  install -Dm644 "$generated/completions/gelpad.fish" -t "$to/share/fish/vendor_completions.d"
  for page in "$generated"/man/*.1; do
    install -d "$to/share/man/man1"
    gzip -9n <"$page" >"$to/share/man/man1/$(basename "$page").gz"
  done
  install -Dm644 "$generated/profile.schema.json" -t "$to/share/gelpad"
  find "$to" -type f ! -perm -u+x -exec chmod 644 {} +
}
