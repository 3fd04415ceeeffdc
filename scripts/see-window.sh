#!/usr/bin/env bash
# Takes pictures of every view of the window at 1280 x 800 and 800 x 500, dark and light, on a virtual display.
#
#   scripts/see-window.sh FOLDER [GELPAD]
#
# Needs Xvfb, xdotool, ImageMagick's `import`, libgl1-mesa-dri and libxkbcommon-x11-0.
set -euo pipefail

folder=$(realpath -m "${1:?a folder for the pictures}")
views=(play practice edit set-up record signals comfort)
mkdir -p "$folder"
. "$(dirname "$0")/window-stage.sh" "${2:-target/release/gelpad}"

for theme in dark light; do
  printf 'theme = "%s"\n' "$theme" >"$work/gelpad/window.toml"
  open_window
  sleep 3
  for size in 1280x800 800x500; do
    xdotool windowsize "$window" "${size%x*}" "${size#*x}"
    sleep 1
    xdotool key F1
    sleep 0.7
    # Two short presses, and a third that is held while the pictures are taken.
    if [ "$size" = 1280x800 ]; then jump=(660 320); run=(640 540); left=(260 300); else jump=(360 190); run=(345 300); left=(190 190); fi
    xdotool mousemove "${left[@]}" mousedown 1; sleep 0.5; xdotool mouseup 1; sleep 0.3
    xdotool mousemove "${jump[@]}" mousedown 1; sleep 0.2; xdotool mouseup 1; sleep 0.3
    xdotool mousemove "${run[@]}" mousedown 1; sleep 0.4
    xdotool key space; xdotool mouseup 1; sleep 0.1
    xdotool mousemove "${jump[@]}" mousedown 1; sleep 0.4
    key=1
    for view in "${views[@]}"; do
      xdotool key "F$key"
      sleep 0.7
      import -silent -window "$window" "$folder/$view-$size-$theme.png"
      key=$((key + 1))
    done
    xdotool key F1; xdotool mouseup 1; sleep 0.3
    xdotool key Escape
  done
  kill "$player"
  wait "$player" 2>/dev/null || true
done
ls "$folder"
