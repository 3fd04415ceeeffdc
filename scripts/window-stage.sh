# What the scripts that look at the window share; sourced, not run. A display of its own with software GL, and a folder for
# settings; both end with the script.
#
#   $gelpad        the program, absolute; $work the folder
#   open_window    starts it, says its process in $player and its window in $window, at 1280 x 800 with the focus
gelpad=$(realpath "${1:-target/release/gelpad}")
work=$(mktemp -d)
export XDG_CONFIG_HOME="$work" LIBGL_ALWAYS_SOFTWARE=1
mkdir -p "$work/gelpad"
player=
Xvfb -displayfd 3 -screen 0 1300x820x24 -nolisten tcp 3>"$work/display" 2>/dev/null &
xvfb=$!
trap 'kill $player $xvfb 2>/dev/null || true; wait 2>/dev/null || true; rm -rf "$work"' EXIT
for _ in $(seq 100); do [ -s "$work/display" ] && break; sleep 0.1; done
DISPLAY=:$(cat "$work/display")
export DISPLAY

open_window() {
  RUST_LOG=gelpad::gui=debug "$gelpad" 2>"$work/log" &
  player=$!
  window=
  for _ in $(seq 1000); do
    window=$(xdotool search --onlyvisible --name '^gelpad$' 2>/dev/null | head -1) && [ -n "$window" ] && break
    sleep 0.01
  done
  [ -n "$window" ] || { cat "$work/log" >&2; echo "no window came" >&2; exit 1; }
  until grep -q 'plays' "$work/log"; do sleep 0.01; done
  xdotool windowmove "$window" 0 0 windowfocus "$window" windowsize "$window" 1280 800
}
