#!/usr/bin/env bash
# How late events are while a busy program runs on every core at the usual priority: from a frame to its events, and to the key that
# an X11 client could see, with gelpad's own priority and without it (`nice` limit 0, as a user without RealtimeKit). Then from the
# bytes of a board on its line to the event that gelpad prints, which counts also how late gelpad wakes to read them; beside it
# the same without the busy programs.
#
#   scripts/two-busy-cores.sh [SECONDS [GELPAD]]      five runs of 60 s each by default, and one to record; needs xvfb and python3
#
# Needs root: for the real-time priority with which it measures, and to play as another user.
set -euo pipefail
cd "$(dirname "$0")/.."
[ "$(id -u)" = 0 ] || { echo "two-busy-cores: run as root, see the head of the script" >&2; exit 2; }
seconds=${1:-60}
gelpad=$(realpath "${2:-target/release/gelpad}")
work=$(mktemp -d)
chmod 755 "$work"
started=()
trap 'kill "${started[@]}" 2>/dev/null || true; wait 2>/dev/null || true; rm -rf "$work"' EXIT

Xvfb -displayfd 3 -noreset -screen 0 640x480x24 -nolisten tcp 3>"$work/display" 2>/dev/null &
started+=($!)
until [ -s "$work/display" ]; do
  kill -0 "${started[0]}" 2>/dev/null || { echo "Xvfb did not start" >&2; exit 1; }
  sleep 0.1
done
DISPLAY=:$(cat "$work/display")
export DISPLAY XDG_CONFIG_HOME=$work
# Presses of 40 to 200 ms, three a second.
awk -v end="$seconds" 'BEGIN { for (at = 500; at < 1000 * end; at += 333) {
  printf "t:%d down 1 %d 50\nt:%d up 1\n", at, 76 + at % 9, at + 40 + at % 161 } }' >"$work/touches.txt"

# The frames of such a session, for the line, and their events.
{
  "$gelpad" play super-mario --source "simulated:$work/touches.txt" --output trace --headless --seed 2 --record "$work/session.mcap" \
    >/dev/null &&
    "$gelpad" export "$work/session.mcap" --format csv --output "$work/frames.csv" &&
    "$gelpad" replay "$work/frames.csv" --print events >"$work/events.txt"
} 2>"$work/said" || { cat "$work/said" >&2; exit 1; }
# Writes each frame to a pseudo-terminal at its time, and reads the time of each event as it is printed. It runs before all
# else, so that what is late is gelpad.
cat >"$work/line.py" <<'PYTHON'
import os, pty, subprocess, sys, threading, time, tty
gelpad, folder, *before = sys.argv[1:]
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(50))
frames = [row.rstrip("\n").split(",", 1) for row in open(folder + "/frames.csv")][1:]
expected = [line.split()[0] for line in open(folder + "/events.txt")]
board, port = pty.openpty()
tty.setraw(port)
os.fchmod(port, 0o666)
play = subprocess.Popen(
    [*before, gelpad, "play", "super-mario", "--source", "serial:" + os.ttyname(port), "--format", "lines", "--output", "trace",
     "--headless"], stdout=subprocess.PIPE, stderr=open(folder + "/said", "w"),
    preexec_fn=lambda: os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0)))
seen = []


def read():
    for line in play.stdout:
        seen.append((time.monotonic(), line))


def fail(why):
    sys.exit(f"{why}\n{open(folder + '/said').read()}")


def send_frames():
    """Writes each frame at its time; returns when each was written."""
    start, written = time.monotonic(), {}
    for t_ms, values in frames:
        time.sleep(max(0, start + float(t_ms) / 1e3 - time.monotonic()))
        written[float(t_ms)] = time.monotonic()
        line = memoryview((values + "\n").encode())
        while line:
            try:
                line = line[os.write(board, line):]
            except BlockingIOError:
                if time.monotonic() > written[float(t_ms)] + 2:
                    fail("gelpad does not read")
                time.sleep(0.0005)
        if play.poll() is not None:
            fail("gelpad has ended")
    return written


os.set_blocking(board, False)
reader = threading.Thread(target=read, daemon=True)
reader.start()
try:
    time.sleep(2)
    written = send_frames()
    time.sleep(0.5)
finally:
    play.terminate()
reader.join(5)
events = [at for at, line in seen if line.split()[0].replace(b".", b"").isdigit()]
if len(events) != len(expected):
    fail(f"{len(events)} events instead of {len(expected)}")
late_ms = sorted((at - written[float(t_ms)]) * 1e3 for at, t_ms in zip(events, expected))
at = lambda share: late_ms[min(len(late_ms) - 1, int(share * len(late_ms)))]
print(f"  {len(late_ms)} events, line to event: median {at(0.5):.2f} ms, p99 {at(0.99):.2f} ms, at most {late_ms[-1]:.2f} ms")
PYTHON
echo "without busy programs:"
python3 "$work/line.py" "$gelpad" "$work"
for _ in $(seq "$(nproc)"); do
  (while :; do :; done) &
  started+=($!)
done

play() {
  "$@" "$gelpad" play super-mario --source "simulated:$work/touches.txt" --output keyboard --headless --seed 1 >"$work/said" 2>&1 ||
    { cat "$work/said" >&2; exit 1; }
  grep -E 'frame to|by stage|late' "$work/said" | sed 's/^/  /'
}
echo "with gelpad's priority:"
play env
python3 "$work/line.py" "$gelpad" "$work"
echo "without:"
# Root may always ask for a higher priority, so another user plays.
mkdir -m 777 "$work/home"
other=(setpriv --reuid=65534 --regid=65534 --clear-groups env -u XDG_RUNTIME_DIR HOME="$work/home" XDG_CONFIG_HOME="$work/home"
  prlimit --nice=0:0)
play "${other[@]}"
python3 "$work/line.py" "$gelpad" "$work" "${other[@]}"
