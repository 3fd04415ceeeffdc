#!/usr/bin/env bash
# Tests gelpad for Windows under wine: unit tests, scenarios, profiles and pads, keys into a window that logs them, kills, and recordings that are
# replayed there and here to the same bytes. Needs the packages of scripts/windows-toolchain.sh, xvfb and socat.
#
#   scripts/test-windows.sh [GELPAD]      GELPAD: gelpad for this system, target/debug/gelpad by default
set -euo pipefail
cd "$(dirname "$0")/.."
gelpad=$(realpath "${1:-target/debug/gelpad}")
# The tests build the program with them; building it alone first would compile some crates twice.
tests=(--features vigem --lib --test scenarios --test profiles --test windows)
scripts/cargo-windows.sh test --quiet --no-run "${tests[@]}"
exe=$PWD/target/windows/x86_64-pc-windows-gnu/debug/gelpad.exe
work=$(mktemp -d)
started=()
# Everything that is started ends with the script.
trap 'exec 2>/dev/null; kill "${started[@]}" || true; WINEPREFIX=$WINEPREFIX wineserver64 -k || true; rm -rf "$work"' EXIT
step() { printf -- '-- %s\n' "$*"; }

export WINEPREFIX=$work/wine WINEDEBUG=-all WINEDLLOVERRIDES="mscoree,mshtml=" XDG_RUNTIME_DIR=$work
PATH=$PATH:/usr/lib/wine
Xvfb -displayfd 3 -noreset -nolisten tcp -screen 0 1280x1024x24 3>"$work/display" 2>/dev/null &
started+=($!)
until [ -s "$work/display" ]; do sleep 0.1; done
export DISPLAY=:$(cat "$work/display")
unset WAYLAND_DISPLAY
# One server for all: a program does not wait for a new one. It must be the first to start.
mkdir "$WINEPREFIX"
wineserver64 -p >/dev/null 2>&1
wine64 wineboot --init >/dev/null 2>&1

windows() { scripts/run-in-wine.sh "$exe" "$@"; }
# The same in the background: `exec`, so that its process is the program and not a shell before it.
start_windows() {
  (exec scripts/run-in-wine.sh "$exe" "$@") &
  started+=($!)
}
# At once: wine may leave a request to end unheard.
stop() { kill -KILL "$1" && wait "$1" 2>/dev/null || true; }
path() { printf 'Z:%s' "$(realpath -m "$1" | tr / '\\')"; }

step "it starts, and says what it is"
windows --version

step "frames replay to the same events and touches, and the pad is solved to the same table"
frames=tests/data/lattice-presses/session.csv
for kind in events touches; do
  GELPAD_CACHE=$work/cache-here "$gelpad" replay "$frames" --print $kind >"$work/here.$kind" 2>/dev/null
  GELPAD_CACHE=$(path "$work/cache-there") windows replay "$(path "$frames")" --print $kind >"$work/there.$kind" 2>/dev/null
  # Windows ends its lines as Linux does.
  cmp "$work/here.$kind" "$work/there.$kind"
  wc -lc "$work/there.$kind" | awk -v kind=$kind '{ print "   " kind ": " $1 " lines, " $2 " bytes equal" }'
done
(cd "$work/cache-here" && find . -type f | sort | xargs md5sum) >"$work/tables-here"
(cd "$work/cache-there" && find . -type f | sort | xargs md5sum) >"$work/tables-there"
diff "$work/tables-here" "$work/tables-there"
echo "   tables: $(wc -l <"$work/tables-here") files, $(du -sb "$work/cache-here" | cut -f1) bytes equal"
export GELPAD_CACHE
GELPAD_CACHE=$(path "$work/cache-there")

step "a recording made there is replayed here, and one made here there"
printf 't:300 down 1 80 30\nt:700 up 1\nt:1200 down 1 30 20\nt:1260 up 1\nt:1800 down 2 80 30\nt:1900 up 2\n' >"$work/touches.txt"
play=(play super-mario --source)
windows "${play[@]}" "simulated:$(path "$work/touches.txt")" --output trace --headless --seed 1 \
  --record "$(path "$work/there.mcap")" >/dev/null 2>&1
GELPAD_CACHE=$work/cache-here "$gelpad" "${play[@]}" "simulated:$work/touches.txt" --output trace --headless --seed 1 \
  --record "$work/here.mcap" >/dev/null 2>&1
for made in here there; do
  "$gelpad" replay "$work/$made.mcap" --print events >"$work/$made.on-linux" 2>/dev/null
  windows replay "$(path "$work/$made.mcap")" --print events >"$work/$made.on-windows" 2>/dev/null
  cmp "$work/$made.on-linux" "$work/$made.on-windows"
  echo "   made $made: $(wc -l <"$work/$made.on-linux") events equal"
done
windows replay "$(path "$work/there.mcap")" --update "$(path "$work/there.events")" 2>/dev/null
"$gelpad" replay "$work/there.mcap" --expect "$work/there.events" 2>/dev/null

step "Ctrl-C in a console releases the key"
printf 't:300 down 1 80 30\nt:60000 up 1\n' >"$work/hold.txt"
hold="scripts/run-in-wine.sh '$exe' play super-mario --source 'simulated:$(path "$work/hold.txt")' --output keyboard --headless --seed 1"
code=0
(sleep 6 && printf '\003' && sleep 3) | timeout 60 script -qefc "$hold" "$work/console" >/dev/null 2>&1 || code=$?
[ "$code" = 130 ] || { cat "$work/console"; echo "exit code $code instead of 130" >&2; exit 1; }

step "without the driver ViGEmBus a gamepad is refused with a reason"
code=0
windows play racing --source "simulated:$(path "$work/hold.txt")" --output gamepad --headless >/dev/null 2>"$work/refused" || code=$?
sed 's/^/   /' "$work/refused"
[ "$code" != 0 ] && grep -q 'ViGEmBus, which is not installed' "$work/refused"

step "a board on COM5"
"$gelpad" device --port "$work/board" --format openeit --pad openeit-lattice >/dev/null 2>"$work/device" &
started+=($!)
until [ -e "$work/board" ]; do sleep 0.1; done
ln -sf "$work/board" "$WINEPREFIX/dosdevices/com5"
windows listen COM5 >"$work/listened" 2>&1 || true
sed 's/^/   /' "$work/listened" | head -12
grep -qi openeit "$work/listened"
timeout 30 scripts/run-in-wine.sh "$exe" play super-mario --pad openeit-lattice --source serial:COM5 --output trace --headless \
  --record "$(path "$work/board.mcap")" >/dev/null 2>"$work/played" || true
tail -3 "$work/played" | sed 's/^/   /'

step "the end of the session releases the key and finishes the recording"
start_windows play super-mario --source "simulated:$(path "$work/hold.txt")" --output keyboard --headless --seed 1 \
  --record "$(path "$work/ended.mcap")" >/dev/null 2>"$work/ended"
held=${started[-1]}
sleep 6
wine64 wineboot --end-session >/dev/null 2>&1
wait $held 2>/dev/null || true
"$gelpad" replay "$work/ended.mcap" --print events >"$work/ended.events" 2>"$work/ended" || { cat "$work/ended"; exit 1; }
tail -2 "$work/ended.events" | sed 's/^/   /'
tail -1 "$work/ended.events" | grep -q release
wine64 wineboot --init >/dev/null 2>&1

step "the window, pressed with the mouse"
start_windows >/dev/null 2>"$work/window"
xdotool search --sync --onlyvisible --name '^gelpad' >"$work/id"
sleep 3
# The pad's region `jump`, and the card that shows the length of each press.
read -r left top < <(xdotool getwindowgeometry --shell "$(head -1 "$work/id")" | sed -n 's/^[XY]=//p' | paste -sd' ')
card() { import -window root -crop 300x60+$((left + 910))+$((top + 470)) ppm:- | md5sum; }
before=$(card)
xdotool mousemove $((left + 600)) $((top + 300)) mousedown 1 sleep 0.4 mouseup 1
sleep 1
[ "$before" != "$(card)" ] || { echo "the window shows no press" >&2; exit 1; }
stop "${started[-1]}"

step "tests"
GELPAD_KEY_TABLE=$(path "$work/keys.txt")
export GELPAD_KEY_TABLE
scripts/cargo-windows.sh test --quiet --features vigem --lib --test scenarios --test profiles
# What keys, kills and latency measured is printed.
scripts/cargo-windows.sh test --quiet --features vigem --test windows -- --nocapture
cp "$work/keys.txt" target/windows/keys.txt
echo "   key table: $(($(wc -l <"$work/keys.txt") - 1)) keys in target/windows/keys.txt"
