#!/usr/bin/env bash
# Makes the pictures of the README and the guide: the live view of the level in a terminal on a display of its own, and
# the figures of the phantoms and of the accuracy, and the window's views.
# Needs the Debian packages xvfb, xterm, xdotool, fonts-dejavu-core, imagemagick, libgl1-mesa-dri and libxkbcommon-x11-0;
# writes docs/live.png, docs/phantoms.png, docs/accuracy.png, docs/window-*.png and docs/jump.gif (by docs/make-animation.sh).
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --quiet
display=$(mktemp)
Xvfb -displayfd 1 -noreset -screen 0 1092x680x24 >"$display" 2>/dev/null &
server=$!
trap 'kill "$server"; rm -f "$display"' EXIT
until [ -s "$display" ]; do sleep 0.1; done
export DISPLAY=":$(cat "$display")" COLORTERM=truecolor
xterm -geometry 120x35+0+0 -fa 'DejaVu Sans Mono' -fs 11 -bg black -fg gray90 -b 6 -e env -u DISPLAY -u WAYLAND_DISPLAY target/release/gelpad &
# At 6.4 s three fingers are down: right, run and jump.
sleep 6.9
import -window root docs/live.png
wait %2 || true
study=$(mktemp -d)
target/release/gelpad study phantoms --out "$study" >/dev/null
cp "$study/phantoms.png" docs/phantoms.png
target/release/gelpad accuracy --pad edinburgh-lattice --seed 1 --out "$study" >/dev/null
cp "$study/accuracy.png" docs/accuracy.png
SIZES="1280x800" THEMES=dark SCALES=100 scripts/see-window.sh "$study/window" >/dev/null
SIZES="800x600" THEMES=light SCALES=100 scripts/see-window.sh "$study/window" >/dev/null
for view in play practice edit set-up record signals comfort; do
  convert "$study/window/$view-1280x800-dark.png" -strip -colors 128 "docs/window-$view.png"
done
scripts/mouse-plays-level.sh target/release/gelpad "$study/level.png"
convert "$study/level.png" -strip -colors 128 docs/window-practice.png
convert "$study/window/play-800x600-light.png" -strip -colors 128 docs/window-small-light.png
docs/make-animation.sh docs/jump.gif
rm -r "$study"
echo "docs/live.png docs/phantoms.png docs/accuracy.png docs/window-*.png docs/jump.gif"
