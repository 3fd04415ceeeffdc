#!/usr/bin/env bash
# Opens gelpad's window on a display and an accessibility bus of its own, and walks it with walk.py.
#
#   tests/screen_reader/run.sh GELPAD
set -euo pipefail
. "$(dirname "$0")/../../scripts/window-stage.sh" "$1"
mkdir -m 700 "$work/run"
# No bus of the desktop, if there is one.
unset DBUS_SESSION_BUS_ADDRESS AT_SPI_BUS_ADDRESS WAYLAND_DISPLAY
export XDG_RUNTIME_DIR=$work/run gelpad
walk=$(realpath "$(dirname "$0")/walk.py")
export walk
dbus-run-session -- bash -euo pipefail -c '
  /usr/libexec/at-spi-bus-launcher --launch-immediately &
  launcher=$!
  "$gelpad" >"$XDG_RUNTIME_DIR/said" 2>&1 &
  player=$!
  trap "kill $player $launcher 2>/dev/null || true" EXIT
  # As a screen reader does when it starts.
  for name in IsEnabled ScreenReaderEnabled; do
    deadline=$((SECONDS + 60))
    until dbus-send --session --print-reply --dest=org.a11y.Bus /org/a11y/bus org.freedesktop.DBus.Properties.Set \
      string:org.a11y.Status "string:$name" variant:boolean:true >/dev/null 2>&1; do
      [ $SECONDS -le $deadline ] || { echo "the accessibility bus did not start" >&2; exit 1; }
      sleep 0.1
    done
  done
  timeout 600 /usr/bin/python3 "$walk" || { cat "$XDG_RUNTIME_DIR/said" >&2; exit 1; }
'
