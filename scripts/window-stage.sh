# Sourced by the scripts that drive the window: starts a virtual display with software OpenGL and a temporary settings folder, and
# removes both when the script ends.
#
#   $screen_size   size of the screen, if set before [default: 1300x820]
#   $gelpad        absolute path of the program
#   $work          the temporary folder
#   $screen        the file that holds the screen, in the format of xwd
#   open_window    starts gelpad at 1280 x 800 with the focus; sets $player (process) and $window (window id)
gelpad=$(realpath "${1:-target/release/gelpad}")
work=$(mktemp -d)
export XDG_CONFIG_HOME="$work" LIBGL_ALWAYS_SOFTWARE=1
mkdir -p "$work/gelpad"
player=
# Without -noreset, the server restarts whenever its last client leaves and refuses clients that connect meanwhile: one in ten
# connections failed while xdotool looked for the window every 10 ms.
Xvfb -displayfd 3 -noreset -screen 0 "${screen_size:-1300x820}x24" -nolisten tcp -fbdir "$work" 3>"$work/display" 2>/dev/null &
xvfb=$!
trap 'kill $player $xvfb 2>/dev/null || true; wait 2>/dev/null || true; rm -rf "$work"' EXIT
until [ -s "$work/display" ]; do
  kill -0 "$xvfb" 2>/dev/null || { echo "Xvfb did not start" >&2; exit 1; }
  sleep 0.1
done
screen=$work/Xvfb_screen0
DISPLAY=:$(cat "$work/display")
export DISPLAY

open_window() {
  RUST_LOG=warn,gelpad::gui=debug "$gelpad" 2>"$work/log" &
  player=$!
  window=
  local deadline=$((SECONDS + 120))
  until [ -n "$window" ] && grep -q 'plays' "$work/log"; do
    # Without a window, gelpad plays the level in the terminal and says why.
    if ! kill -0 "$player" 2>/dev/null || grep -q 'plays here' "$work/log" || [ $SECONDS -gt $deadline ]; then
      cat "$work/log" >&2
      echo "the window did not open" >&2
      exit 1
    fi
    window=$(xdotool search --onlyvisible --name '^gelpad$' 2>/dev/null | head -1) || true
    sleep 0.01
  done
  xdotool windowmove "$window" 0 0 windowfocus "$window" windowsize "$window" 1280 800
}
