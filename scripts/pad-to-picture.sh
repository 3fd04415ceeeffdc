#!/usr/bin/env bash
# From a press of the pad to the game's picture: a simulated board (gelpad device, a packet for each drive) on a pseudo-terminal, gelpad,
# XTEST, and a game under Xvfb. A press happens at a known time; the time until a pixel of the game changes is measured, beside a key that is
# sent by XTEST directly. gelpad's share is the difference. Medians and 95th percentiles, at 100 and at 10 frames a second.
# Needs the Debian packages xvfb, xdotool, python3, and fceux with cc65, or supertux; uses its own display.
#
#   scripts/pad-to-picture.sh [PRESSES] [fceux|supertux]      20 presses in fceux by default: one and a half minutes
set -euo pipefail
presses=${1:-20}
game_name=${2:-fceux}
source "$(dirname "$0")/stage.sh"
stage 800x700
case $game_name in
  fceux)
    rom
    profile=super-mario key=f
    QT_QPA_PLATFORM=xcb fceux --no-config 1 --sound 0 "$folder/jump.nes" >"$folder/said" 2>&1 &
    keep $!
    xdotool search --sync --onlyvisible --class fceux windowfocus --sync
    sleep 5 # the game draws itself
    ;;
  supertux)
    profile=supertux key=space
    flat_level
    supertux "$folder/flat.stl"
    ;;
  *)
    echo "unknown game $game_name: fceux or supertux" >&2
    exit 2
    ;;
esac

python3 - "$presses" "$gelpad" "$folder" "$profile" "$key" <<'PYTHON'
import mmap, os, random, signal, subprocess, sys, time

presses, gelpad, folder, profile, key = int(sys.argv[1]), *sys.argv[2:]
random.seed(1)
# A jump and the fall after it.
HOLD_S, PAUSE_S, FIRST_S = 0.3, 1.6, 4.5
screen = open(folder + "/Xvfb_screen0", "rb")
pixels = mmap.mmap(screen.fileno(), 0, access=mmap.ACCESS_READ)
ROW = 4 * 800


def picture():
    """Every sixth row of the screen, which Xvfb keeps in an XWD file: a figure that jumps is higher than that."""
    return [pixels[at : at + ROW] for at in range(len(pixels) - 700 * ROW, len(pixels), 6 * ROW)]


def picture_change(after, limit=1.0):
    """Seconds from a time to the next change of the picture; none if there is none."""
    while time.monotonic() < after:
        time.sleep(0.0005)
    first = picture()
    while time.monotonic() < after + limit:
        if picture() != first:
            return time.monotonic() - after
        time.sleep(0.0005)
    return None


def report(name, times):
    seen = sorted(1e3 * t for t in times if t is not None)
    if not seen:
        print(f"{name}: no press was seen")
        return None
    at = lambda share: seen[round(share * (len(seen) - 1))]
    print(f"{name}: {len(seen)} of {len(times)} presses, median {at(0.5):.0f} ms, p95 {at(0.95):.0f} ms", flush=True)
    return at(0.5)


def press_times(start):
    t = start
    for _ in range(presses):
        yield t
        t += HOLD_S + PAUSE_S + random.uniform(0, 0.25)


# A key by XTEST, without gelpad.
xdotool = subprocess.Popen(["xdotool", "-"], stdin=subprocess.PIPE, text=True)
times = []
for at in press_times(time.monotonic() + 0.5):
    time.sleep(max(0, at - time.monotonic()))
    sent = time.monotonic()
    print(f"keydown {key}", file=xdotool.stdin, flush=True)
    times.append(picture_change(sent))
    time.sleep(HOLD_S)
    print(f"keyup {key}", file=xdotool.stdin, flush=True)
xdotool.stdin.close()
xdotool.wait()
direct = report("a key by XTEST", times)

for rate in (100, 10):
    offsets = list(press_times(FIRST_S))
    with open(folder + "/touches.txt", "w") as script:
        for at in offsets:
            script.write(f"t:{1e3 * at:.0f} down 1 80 50\nt:{1e3 * (at + HOLD_S):.0f} up 1\n")
        script.write(f"t:{1e3 * (offsets[-1] + 3):.0f} end\n")
    port = folder + "/port"
    device = subprocess.Popen(
        [gelpad, "device", "--port", port, "--format", "gelpad", "--by-drive", "--rate", str(rate), "--script", folder + "/touches.txt"],
        stderr=subprocess.PIPE, text=True)
    while not os.path.exists(port):
        time.sleep(0.01)
    player = subprocess.Popen(
        [gelpad, "play", profile, "--source", f"serial:{port}", "--format", "gelpad", "--output", "keyboard", "--headless"],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    for line in device.stderr:
        if "opened" in line:
            break
    start = time.monotonic()
    times = [picture_change(start + at) for at in offsets]
    for process in (player, device):
        process.send_signal(signal.SIGTERM)
        process.wait()
    median = report(f"a press at {rate} frames/s", times)
    if median and direct:
        print(f"  gelpad and the board take {median - direct:.0f} ms of it")
PYTHON
