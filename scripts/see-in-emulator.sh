#!/usr/bin/env bash
# Plays a super-mario profile into an emulator and prints how the figure of the game (tests/game/jump.s) moves: right, left,
# jump (A), run right (B). Needs the Debian packages xvfb, xdotool, cc65, python3 and the emulator; uses its own display.
#
#   scripts/see-in-emulator.sh super-mario-mednafen mednafen -sound 0 -video.driver softfb -nes.xscale 2 -nes.yscale 2
#   scripts/see-in-emulator.sh super-mario-retroarch retroarch -L /usr/lib/x86_64-linux-gnu/libretro/nestopia_libretro.so
set -euo pipefail
profile=$1
shift
source "$(dirname "$0")/stage.sh"
rom
stage 800x700
mkdir -p "$folder/.config/retroarch"
"$@" "$folder/jump.nes" >"$folder/said" 2>&1 &
keep $!
sleep 8 # the game draws itself
# Without a window manager some windows need the focus to get keys; others cannot be found by name.
xdotool search --onlyvisible --name . windowfocus 2>/dev/null || true

cat >"$folder/touches.txt" <<'TOUCHES'
t:1000 down 1 37 55   # right
t:1800 up 1
t:2600 down 1 13 55   # left
t:3400 up 1
t:4200 down 1 80 50   # A
t:5000 up 1
t:5800 down 1 75 9    # B, and right
t:5900 down 2 37 55
t:6700 up 2
t:6800 up 1
t:7500 end
TOUCHES
play "$profile" &
player=$!
keep "$player"

# Compares the screen with its start: the differences are the old and new place of the figure. Xvfb keeps the screen in an
# XWD file.
python3 - "$folder/Xvfb_screen0" "$player" <<'PYTHON'
import os, struct, sys, time

def screen():
    data = open(sys.argv[1], "rb").read()
    head = struct.unpack(">25I", data[:100])
    start, row = head[0] + 12 * head[19], head[12]
    return [data[at : at + row] for at in range(start, start + row * head[5], row)]

first, begun, last = screen(), time.time(), None
while os.path.exists(f"/proc/{sys.argv[2]}/exe"):
    now = screen()
    rows = [y for y in range(0, len(now), 2) if now[y] != first[y]]
    columns = [x for y in rows[::6] for x in range(0, len(now[y]) // 4, 2) if now[y][4 * x : 4 * x + 4] != first[y][4 * x : 4 * x + 4]]
    seen = (min(columns), max(columns), rows[0], rows[-1]) if columns else None
    if seen != last:
        print(f"{time.time() - begun:6.2f} s ", "x %d to %d, y %d to %d px" % seen if seen else "at the start", flush=True)
        last = seen
    time.sleep(0.08)
PYTHON
