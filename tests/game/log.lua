-- Runs inside fceux and logs every frame that the game saw, one CSV line each,
-- to the file named by the environment variable GELPAD_GAME_LOG:
--
--   frame    the emulator's frame counter
--   time_ms  wall clock (Unix time), microsecond steps
--   A..right the buttons of pad 1, 0 or 1
--   x, y     the figure's place in pixels, y downwards (addresses: jump.s)
--
-- Lua 5.1 has no fine wall clock: os.time() counts seconds, os.clock() the
-- processor's time, /proc/uptime steps of 10 ms. So the lines go through a pipe
-- to a bash, which stamps each as it arrives and writes it out at once; bash
-- reads the clock without starting a program. It ends when the pipe closes, that
-- is with fceux, however that ends.

local PLAYER_X, PLAYER_Y = 0x02, 0x03
local BUTTONS = { "A", "B", "select", "start", "up", "down", "left", "right" }

local STAMP = [[
while IFS=, read -r frame rest; do
    us=${EPOCHREALTIME/./}
    echo "$frame,${us%???}.${us: -3},$rest"
done
]]

assert(os.getenv("GELPAD_GAME_LOG"), "GELPAD_GAME_LOG names no file")
local header = "frame,time_ms," .. table.concat(BUTTONS, ",") .. ",x,y"
local log = assert(io.popen(
    "exec >\"$GELPAD_GAME_LOG\"; echo '" .. header .. "'; LC_ALL=C exec bash -c '" .. STAMP .. "'", "w"))

while true do
    local held = joypad.get(1)
    local line = { emu.framecount() }
    for _, button in ipairs(BUTTONS) do
        table.insert(line, held[button] and 1 or 0)
    end
    table.insert(line, memory.readbyte(PLAYER_X))
    table.insert(line, memory.readbyte(PLAYER_Y))
    log:write(table.concat(line, ","), "\n")
    log:flush()
    emu.frameadvance()
end
