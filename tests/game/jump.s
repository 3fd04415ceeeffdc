; A small NES game of our own: a figure that walks and jumps on a strip of
; grass. The end-to-end test plays it in a real emulator, so that what a touch
; on the pad does to a game can be read, frame by frame, from its memory.
;
; The jump is the one that makes a press's length matter (Super Mario Bros has
; the same kind): gravity is weak while A stays held on the way up, and strong
; otherwise. The figure rises 4 + 3.875 + ... + 0.125 = 66 pixels when A is held
; for all of the 32 frames of the rise, about half of that for 5 frames.
;
;     ca65 jump.s -o jump.o && ld65 -C nrom.cfg jump.o -o jump.nes

; ---- State that the test reads: these addresses are an interface -------------
; tests/game/log.lua reads the place; the rest is there for a debugger.

frame     = $00                 ; counts frames, wraps at 256
buttons   = $01                 ; held now: A B select start up down left right,
                                ; A in bit 7
player_x  = $02                 ; left edge of the figure, pixels
player_y  = $03                 ; top edge of the figure, pixels, grows downwards
on_ground = $04                 ; 1 on the ground, 0 in the air

; ---- State of the game's own ------------------------------------------------

player_x_sub = $08              ; 1/256 pixels below player_x
player_y_sub = $09              ; 1/256 pixels below player_y
speed_y      = $0A              ; 1/256 pixels a frame, signed, low byte first
gravity      = $0C              ; added to speed_y in each frame in the air
pressed      = $0D              ; buttons held now that were not a frame ago
step         = $0E              ; this frame's way sideways, 1/256 pixels, low
                                ; byte first

oam = $0200                     ; sprites as the next vblank copies them

; ---- What the game feels like ------------------------------------------------

JUMP_SPEED   = $0400            ; 4 pixels a frame upwards at take-off
RISE_GRAVITY = $20              ; 1/8 pixel a frame, each frame: A held, rising
FALL_GRAVITY = $70              ; 7/16: A let go, or past the top
FALL_SPEED   = $04              ; fastest fall, whole pixels a frame
WALK_STEP    = $0180            ; 1.5 pixels a frame
RUN_STEP     = $0280            ; 2.5 pixels a frame

START_X  = 120
MIN_X    = 8
MAX_X    = 232                  ; the figure is 16 wide: keeps it on the screen
GROUND_Y = 184                  ; top of the figure when it stands
GROUND_ROW = (GROUND_Y + 16) / 8 ; row of tiles it stands on
SCREEN_ROWS = 30

; ---- Hardware ----------------------------------------------------------------

PPUCTRL   = $2000
PPUMASK   = $2001
PPUSTATUS = $2002
OAMADDR   = $2003
PPUSCROLL = $2005
PPUADDR   = $2006
PPUDATA   = $2007
DMCFREQ   = $4010
OAMDMA    = $4014
JOY1      = $4016
JOY2      = $4017               ; written: the sound chip's frame interrupt

BUTTON_A     = %10000000
BUTTON_B     = %01000000
BUTTON_LEFT  = %00000010
BUTTON_RIGHT = %00000001

MIRRORED = %01000000            ; sprite attribute: flipped left to right

.segment "HEADER"
        .byte "NES", $1A
        .byte 1                 ; 16 KiB of program, seen at $8000 and at $C000
        .byte 1                 ; 8 KiB of tiles
        .byte 0, 0              ; mapper 0 (NROM)

.segment "CODE"

reset:  sei
        cld
        ldx #$40
        stx JOY2                ; no interrupts from the sound chip
        ldx #$FF
        txs
        inx                     ; 0
        stx PPUCTRL             ; no vblank interrupt until all is set up
        stx PPUMASK
        stx DMCFREQ
        bit PPUSTATUS           ; forget a vblank from before the reset
        jsr wait_for_vblank     ; the PPU takes two frames to warm up; memory is
        jsr clear_memory        ; cleared meanwhile
        jsr wait_for_vblank
        jsr load_palette
        jsr draw_ground
        jsr place_player
        lda #%10000000
        sta PPUCTRL             ; vblank interrupt on
        lda #%00011110
        sta PPUMASK             ; show background and sprites

; One turn a frame. The pad is read right after vblank, and exactly once.
play:   lda frame
@wait:  cmp frame               ; the interrupt counts it up
        beq @wait
        jsr read_joypad
        jsr walk
        jsr jump
        jsr draw_player
        jmp play

nmi:    pha
        lda #0
        sta OAMADDR
        lda #>oam
        sta OAMDMA
        lda #0
        sta PPUSCROLL
        sta PPUSCROLL
        inc frame
        pla
        rti

irq:    rti                     ; nothing raises it

; ---- The game ----------------------------------------------------------------

; Reads the eight buttons into `buttons`, the fresh ones into `pressed`.
read_joypad:
        lda buttons
        eor #$FF
        sta pressed             ; what was up a frame ago
        lda #1
        sta JOY1                ; strobe: the pad latches its buttons
        sta buttons             ; this 1 falls out at the top after eight shifts
        lsr a
        sta JOY1
@bit:   lda JOY1
        lsr a
        rol buttons
        bcc @bit
        lda buttons
        and pressed
        sta pressed
        rts

; Left and right move by a fixed step: no inertia, so that the test can tell the
; frames a key was held from the way walked.
walk:   lda #<WALK_STEP
        ldx #>WALK_STEP
        bit buttons
        bvc @step               ; overflow is bit 6: B
        lda #<RUN_STEP
        ldx #>RUN_STEP
@step:  sta step
        stx step+1
        lda buttons
        and #BUTTON_RIGHT
        bne @right
        lda buttons
        and #BUTTON_LEFT
        bne @left
        rts
@right: clc
        lda player_x_sub
        adc step
        sta player_x_sub
        lda player_x
        adc step+1
        cmp #MAX_X
        bcc @move
        lda #MAX_X
        bne @stop               ; always
@left:  sec
        lda player_x_sub
        sbc step
        sta player_x_sub
        lda player_x
        sbc step+1
        cmp #MIN_X
        bcs @move
        lda #MIN_X
@stop:  ldx #0
        stx player_x_sub
@move:  sta player_x
        rts

; A jump needs a fresh press of A: holding it makes one jump, not many.
jump:   lda on_ground
        beq @airborne
        bit pressed
        bpl @done               ; negative is bit 7: A
        lda #<-JUMP_SPEED
        sta speed_y
        lda #>-JUMP_SPEED
        sta speed_y+1
        lda #RISE_GRAVITY
        sta gravity
        lda #0
        sta on_ground
@airborne:
        bit speed_y+1
        bpl @heavy              ; past the top
        bit buttons
        bmi @move               ; still rising and A still held
@heavy: lda #FALL_GRAVITY       ; and so it stays: pressing A again in the air
        sta gravity             ; does not help
@move:  clc
        lda player_y_sub
        adc speed_y
        sta player_y_sub
        lda player_y
        adc speed_y+1
        sta player_y
        cmp #GROUND_Y
        bcs @land
        clc
        lda speed_y
        adc gravity
        sta speed_y
        bcc @limit
        inc speed_y+1
@limit: lda speed_y+1
        bmi @done               ; rising: no limit
        cmp #FALL_SPEED
        bcc @done
        lda #FALL_SPEED
        sta speed_y+1
        lda #0
        sta speed_y
@done:  rts
@land:  jmp stand

; ---- The figure --------------------------------------------------------------

place_player:
        lda #START_X
        sta player_x
        jsr stand
        jmp draw_player

; Puts the figure on the ground, at rest.
stand:  lda #GROUND_Y
        sta player_y
        lda #0
        sta player_y_sub
        sta speed_y
        sta speed_y+1
        lda #1
        sta on_ground
        rts

; Four sprites of 8 x 8; the right half is the left half mirrored.
draw_player:
        ldx player_y
        dex                     ; the PPU shows sprites a line below their y
        stx oam+0
        stx oam+4
        txa
        clc
        adc #8
        sta oam+8
        sta oam+12
        lda player_x
        sta oam+3
        sta oam+11
        clc
        adc #8
        sta oam+7
        sta oam+15
        lda #TILE_HEAD
        sta oam+1
        sta oam+5
        lda #TILE_BODY
        sta oam+9
        sta oam+13
        lda #0
        sta oam+2
        sta oam+10
        lda #MIRRORED
        sta oam+6
        sta oam+14
        rts

; ---- Setting up --------------------------------------------------------------

wait_for_vblank:
        bit PPUSTATUS
        bpl wait_for_vblank
        rts

; Clears the zero page, and moves all sprites below the screen.
clear_memory:
        ldx #0
@byte:  lda #0
        sta $00,x
        lda #$FF
        sta oam,x
        inx
        bne @byte
        rts

load_palette:
        lda #>$3F00
        ldx #<$3F00
        jsr set_ppu_address
        ldx #0
@color: lda palette,x
        sta PPUDATA
        inx
        cpx #palette_end - palette
        bne @color
        rts

; Fills the screen, row by row: sky, one row of grass, earth down to the bottom.
draw_ground:
        lda #>$2000
        ldx #<$2000
        jsr set_ppu_address
        ldy #0                  ; row
@row:   lda #TILE_SKY
        cpy #GROUND_ROW
        bcc @fill
        lda #TILE_GRASS
        cpy #GROUND_ROW
        beq @fill
        lda #TILE_EARTH
@fill:  ldx #32
@tile:  sta PPUDATA
        dex
        bne @tile
        iny
        cpy #SCREEN_ROWS
        bne @row
        lda #0                  ; the attributes follow: palette 0 everywhere
        ldx #64
@attr:  sta PPUDATA
        dex
        bne @attr
        rts

set_ppu_address:
        sta PPUADDR
        stx PPUADDR
        rts

; Background 0 (sky, earth, grass, dark earth), three unused, sprites 0 (hidden,
; skin, cap and coat, dark).
palette:
        .byte $21, $17, $2A, $07
        .byte $21, $21, $21, $21
        .byte $21, $21, $21, $21
        .byte $21, $21, $21, $21
        .byte $21, $36, $16, $0F
palette_end:

.segment "VECTORS"
        .word nmi, reset, irq

; ---- Tiles -------------------------------------------------------------------
; Eight rows of a colour's low bits, then eight of its high bits.

TILE_SKY   = 0
TILE_GRASS = 1
TILE_EARTH = 2
TILE_HEAD  = 3
TILE_BODY  = 4

.segment "TILES"
        .res 16, 0              ; sky: the backdrop's colour

        .byte %00000000         ; grass over earth
        .byte %00000000
        .byte %00000000
        .byte %00100010
        .byte %01110111
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %11011101
        .byte %10001000
        .byte %00000000
        .byte %00000100
        .byte %00000000

        .byte %11111111         ; earth with stones
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %11111111
        .byte %00000000
        .byte %00110000
        .byte %00000000
        .byte %00000010
        .byte %00000000
        .byte %01000000
        .byte %00001000
        .byte %00000000

        .byte %00000000         ; left half of the head, with a cap
        .byte %00000000
        .byte %00000000
        .byte %00001111
        .byte %00001101
        .byte %00001111
        .byte %00000111
        .byte %00000011
        .byte %00000000
        .byte %00000111
        .byte %00011111
        .byte %00000000
        .byte %00000010
        .byte %00000000
        .byte %00000000
        .byte %00000000

        .byte %00000000         ; left half of the body
        .byte %00000000
        .byte %00010000
        .byte %00110000
        .byte %00001111
        .byte %00001110
        .byte %00001100
        .byte %00111100
        .byte %00000111
        .byte %00011111
        .byte %00001111
        .byte %00000111
        .byte %00001111
        .byte %00001110
        .byte %00001100
        .byte %00111100
