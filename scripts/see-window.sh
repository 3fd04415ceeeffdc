#!/usr/bin/env bash
# Takes pictures of every view of the window on a virtual display: dark and light, text at 100 and 200 %, at three sizes.
#
#   scripts/see-window.sh FOLDER [GELPAD]         every picture: VIEW-SIZE-THEME.png, and VIEW-SIZE-THEME-200.png with large text
#   SIZES="1280x800" THEMES=dark SCALES=100 scripts/see-window.sh FOLDER
#
# Needs Xvfb, xdotool, ImageMagick's `import`, libgl1-mesa-dri and libxkbcommon-x11-0.
set -euo pipefail

folder=$(realpath -m "${1:?a folder for the pictures}")
views=(play practice edit set-up record signals comfort)
screen_size=1940x1100
mkdir -p "$folder"
. "$(dirname "$0")/window-stage.sh" "${2:-target/release/gelpad}"

# A place in the window as fractions of its size, in pixels.
at() { awk "BEGIN{printf \"%d %d\", ${size%x*} * $1, ${size#*x} * $2}"; }

# Two short presses, and two fingers that stay: one is pinned by a right click.
press() {
  xdotool mousemove $(at 0.22 0.38) mousedown 1; sleep 0.5; xdotool mouseup 1; sleep 0.3
  xdotool mousemove $(at 0.48 0.39) mousedown 1; sleep 0.2; xdotool mouseup 1; sleep 0.3
  xdotool mousemove $(at 0.48 0.70) click 3; sleep 0.4
  xdotool mousemove $(at 0.48 0.39) mousedown 1; sleep 0.4
}

# Two recordings for the list.
export XDG_DATA_HOME=$work/data
mkdir -p "$work/data/gelpad/recordings"
printf 't:600 down 1 80 50\nt:1100 up 1\nt:1500 end\n' >"$work/press.txt"
for recording in "level-1 super-mario" "menu large-buttons"; do
  read -r name profile <<<"$recording"
  "$gelpad" play "$profile" --source "simulated:$work/press.txt" --output trace --headless \
    --record "$work/data/gelpad/recordings/$name.mcap" >/dev/null 2>&1
done

for theme in ${THEMES:-dark light}; do
  for scale in ${SCALES:-100 200}; do
    printf 'theme = "%s"\ntext = %s\n' "$theme" "$(awk "BEGIN{print $scale / 100}")" >"$work/gelpad/window.toml"
    open_window
    sleep 3
    for size in ${SIZES:-1280x800 800x600 1920x1080}; do
      xdotool windowsize "$window" "${size%x*}" "${size#*x}"
      sleep 1
      xdotool key F1
      sleep 0.7
      press
      suffix=$theme
      [ "$scale" = 100 ] || suffix=$theme-$scale
      key=1
      for view in "${views[@]}"; do
        xdotool key "F$key"
        sleep 0.7
        import -silent -window "$window" "$folder/$view-$size-$suffix.png"
        key=$((key + 1))
      done
      xdotool key F1; xdotool mouseup 1; sleep 0.3
      xdotool key Escape
    done
    kill "$player"
    wait "$player" 2>/dev/null || true
  done
done
ls "$folder"
