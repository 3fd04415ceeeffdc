# Sourced by the scripts that play into games: a temporary folder, a virtual display, and gelpad playing a touch script into it.
# Everything that is started ends with the script.
#
#   stage SIZE     Xvfb of that size (800x600) on a free display; its picture in $folder/Xvfb_screen0
#   keep PID       ends this process with the script
#   rom            assembles the game of tests/game to $folder/jump.nes
#   play PROFILE   plays $folder/touches.txt into the display; waits for its end
#   supertux [LEVEL]  starts SuperTux there, waits for its level, sets its process in $game
#   flat_level     writes a level of snow, without an end or enemies, to $folder/flat.stl
#   keys_seen      after `kill $game`: for each key the lengths of its presses in steps (64 per second) as SuperTux saw them
cd "$(dirname "${BASH_SOURCE[0]}")/.."
[ -n "${GELPAD_BIN:-}" ] || cargo build --quiet
gelpad=${GELPAD_BIN:-$PWD/target/debug/gelpad}
folder=$(mktemp -d)
started=()
trap 'exec 2>/dev/null; kill -9 "${started[@]}" || true; rm -rf "$folder"' EXIT

keep() { started+=("$1"); }

stage() {
  Xvfb -displayfd 3 -noreset -nolisten tcp -screen 0 "$1x24" -fbdir "$folder" 3>"$folder/display" 2>"$folder/xvfb" &
  keep $!
  until [ -s "$folder/display" ]; do sleep 0.1; done
  DISPLAY=:$(cat "$folder/display")
  # What was solved for the pad is not solved again.
  export XDG_CACHE_HOME=${XDG_CACHE_HOME:-$HOME/.cache}
  export DISPLAY XDG_RUNTIME_DIR=$folder HOME=$folder SDL_AUDIODRIVER=dummy PATH=$PATH:/usr/games
  unset XDG_CONFIG_HOME XDG_DATA_HOME WAYLAND_DISPLAY
}

rom() {
  ca65 tests/game/jump.s -o "$folder/jump.o"
  ld65 -C tests/game/nrom.cfg "$folder/jump.o" -o "$folder/jump.nes"
}

play() {
  "$gelpad" play "$1" --source "simulated:$folder/touches.txt" --output keyboard --headless --seed 1
}

supertux() {
  local level=${1:-/usr/share/games/supertux2/levels/world1/welcome_antarctica.stl}
  SDL_RENDER_DRIVER=software supertux2 --userdir "$folder/user" --window --geometry 640x480 --disable-sound --disable-music \
    --renderer sdl --record-demo "$folder/demo" "$level" >"$folder/said" 2>&1 &
  game=$!
  keep "$game"
  xdotool search --sync --onlyvisible --class supertux2 windowfocus --sync
  sleep 20 # the level has begun, on a slow machine too
}

flat_level() {
  python3 - >"$folder/flat.stl" <<'PYTHON'
width, height, snow = 60, 20, 48
rows = [[snow if y > 15 or x in (0, width - 1) else 0 for x in range(width)] for y in range(height)]
tiles = "\n".join(" ".join(map(str, row)) for row in rows)
print(f"""(supertux-level (version 3) (name "flat") (author "gelpad") (license "CC0")
  (sector (name "main") (camera (name "Camera") (mode "normal"))
    (spawnpoint (name "main") (x 900) (y 400))
    (tilemap (solid #t) (z-pos 0) (width {width}) (height {height}) (tiles {tiles}))))""")
PYTHON
}

# A header of 23 bytes, then six a step; it is written out when the game ends.
keys_seen() {
  wait "$game" 2>/dev/null || true
  python3 - "$folder/demo" <<'PYTHON'
import sys
from itertools import groupby

steps = open(sys.argv[1], "rb").read()[23:]
for place, key in enumerate(["left", "right", "up", "down", "jump", "action"]):
    runs = [len(list(run)) for down, run in groupby(steps[place::6]) if down]
    print(key, *runs)
PYTHON
}
