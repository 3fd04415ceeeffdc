//! Plays a real game from end to end: touches on a simulated pad go through the
//! gelpad binary, its key events through an X server to the emulator fceux, and
//! fceux plays a game of our own (`game/jump.s`), whose memory tells for every
//! frame what it saw and what came of it.
//!
//! Nothing here looks into gelpad: a press that comes too late, too short or not
//! at all shows as a lower jump, as it would to a player.
//!
//! Needs Xvfb, xdotool, cc65, fceux and bash. Where one is missing the trials
//! are ignored, and their kind says why; with `GELPAD_TEST_ALL=1` they fail.

#[path = "game/log.rs"]
mod log;
#[path = "game/process.rs"]
mod process;
#[path = "game/script.rs"]
mod script;
#[path = "game/server.rs"]
mod server;
#[path = "game/stage.rs"]
mod stage;
#[path = "game/tools.rs"]
mod tools;

use std::ops::Range;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow, bail, ensure};
use libtest_mimic::{Arguments, Failed, Trial};

use crate::log::{Log, Press};
use crate::script::{Place, Script};
use crate::stage::Stage;
use crate::tools::Tools;

// Where the regions of the super-mario profiles lie on the pad, mm.
const JUMP: Place = Place { x_mm: 80, y_mm: 50 };
const RUN: Place = Place { x_mm: 75, y_mm: 9 };
const LEFT: Place = Place { x_mm: 13, y_mm: 57 };
const RIGHT: Place = Place { x_mm: 37, y_mm: 57 };

/// Well below and well above the 200 ms that part short from long.
const SHORT_MS: u32 = 80;
const LONG_MS: u32 = 600;
/// Short and long presses in turn, so many in all.
const JUMPS: u32 = 12;
/// From one press to the next: the highest jump (0.9 s in the air) is over.
const JUMP_PERIOD_MS: u32 = 1200;
/// Before the first touch: the pad takes its reference without one.
const LEAD_MS: u32 = 1000;

/// A touch begins and ends anywhere between two frames of the pad, and a key
/// anywhere between two frames of the game: each can cost a frame.
const DIRECT_TOLERANCE_FRAMES: f64 = 2.0;
/// What the classified profile promises, in frames of the game, and how far the
/// game's own sampling of the key may move it.
const CLASSIFIED_SHORT_FRAMES: usize = 5;
const CLASSIFIED_LONG_FRAMES: usize = 32;
const CLASSIFIED_TOLERANCE_FRAMES: usize = 1;

/// Random presses without `GELPAD_PRESSES`, and how long each and the pause after it last.
const PRESSES: usize = 60;
const PRESS_MS: Range<u32> = 34..201;
const PAUSE_MS: Range<u32> = 50..201;
/// The longest press may be seen so many frames long: none sticks.
const LONGEST_FRAMES: usize = 16;

/// A game that draws no frame for so long, ms, has stalled: what it then sees of a press is no longer gelpad's doing.
const STALL_MS: f64 = 30.0;
/// So many jumps at least are judged: the machine is busy, not broken.
const JUDGED: usize = 8;

const WALK_MS: u32 = 600;
const WALK_PERIOD_MS: u32 = 1200;
/// B is down this long before and after the arrow key.
const RUN_MARGIN_MS: u32 = 200;
/// The game runs 2.5 and walks 1.5 pixels a frame: 1.67 times as fast.
const RUN_GAIN: f64 = 1.4;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    // One after the other: the trials measure time, and each runs an emulator.
    arguments.test_threads = Some(1);
    let trials = vec![
        trial("direct", direct),
        trial("classified", classified),
        trial("walking", walking),
        #[cfg(feature = "gui")]
        trial("window", window),
        trial("presses", presses),
    ];
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A trial with a stage of its own, or an ignored one where tools are missing.
fn trial(name: &str, play: fn(&mut Stage) -> Result<()>) -> Trial {
    match Tools::find() {
        Ok(tools) => Trial::test(name, move || {
            on_stage(&tools, play).map_err(|error| Failed::from(format!("{error:#}")))
        }),
        Err(missing) if tools::all_required() => {
            Trial::test(name, move || Err(Failed::from(missing.to_string())))
        }
        Err(missing) => {
            let reason = missing.to_string();
            Trial::test(name, move || Err(Failed::from(missing.to_string())))
                .with_kind(reason)
                .with_ignored_flag(true)
        }
    }
}

/// Plays, and adds to an error what the emulator said.
fn on_stage(tools: &Tools, play: fn(&mut Stage) -> Result<()>) -> Result<()> {
    let mut stage = Stage::start(tools)?;
    play(&mut stage).map_err(|error| anyhow!("{error:#}\n{}", stage.said()))
}

/// A is held while the touch is down: the jump is as high as the press is long.
fn direct(stage: &mut Stage) -> Result<()> {
    let log = stage.play("super-mario", &jump_script())?;
    let jumps = jumps(&log)?;
    for (jump, press_ms) in judged(&jumps)? {
        let expected = f64::from(press_ms) / 1000.0 * log.rate_hz()?;
        ensure!(
            (frames(jump) - expected).abs() <= DIRECT_TOLERANCE_FRAMES,
            "a press of {press_ms} ms held A for {} frames instead of {expected:.1}",
            jump.frames
        );
    }
    ensure_long_jumps_are_higher(&jumps)
}

/// The paper's short and long press: two heights of jump, whatever the touch.
fn classified(stage: &mut Stage) -> Result<()> {
    let log = stage.play("super-mario-classified", &jump_script())?;
    let jumps = jumps(&log)?;
    for (jump, press_ms) in judged(&jumps)? {
        let expected = if press_ms == SHORT_MS {
            CLASSIFIED_SHORT_FRAMES
        } else {
            CLASSIFIED_LONG_FRAMES
        };
        ensure!(
            jump.frames.abs_diff(expected) <= CLASSIFIED_TOLERANCE_FRAMES,
            "a press of {press_ms} ms held A for {} frames instead of {expected}",
            jump.frames
        );
    }
    ensure_long_jumps_are_higher(&jumps)
}

/// The arrows walk, each its own way, and B together with an arrow runs.
fn walking(stage: &mut Stage) -> Result<()> {
    let log = stage.play("super-mario", &walk_script())?;
    let walks = log.presses(|frame| frame.left || frame.right);
    print_walks(&walks);
    let [right, left, run] = walks.as_slice() else {
        bail!("3 touches of the arrows became {} walks", walks.len());
    };
    ensure!(right.way_px > 0, "right walked {} px", right.way_px);
    ensure!(left.way_px < 0, "left walked {} px", left.way_px);
    ensure!(
        px_per_frame(run) > RUN_GAIN * px_per_frame(right),
        "with B {:.2}, without {:.2} px a frame",
        px_per_frame(run),
        px_per_frame(right)
    );
    Ok(())
}

/// Two fingers press at random: the game sees each press once, and none that sticks.
fn presses(stage: &mut Stage) -> Result<()> {
    let count = std::env::var("GELPAD_PRESSES").ok();
    let count = count.and_then(|text| text.parse().ok()).unwrap_or(PRESSES);
    let mut random = Lcg(1);
    let mut script = Script::default();
    // Jump by one finger; right and left in turn by the other.
    let mut wanted = [0; 3];
    for places in [&[(0, JUMP)][..], &[(1, RIGHT), (2, LEFT)]] {
        let mut start_ms = LEAD_MS;
        for press in 0..count / 2 {
            let (button, place) = places[press % places.len()];
            let length_ms = random.within(PRESS_MS);
            script.press(place, start_ms, length_ms);
            start_ms += length_ms + random.within(PAUSE_MS);
            wanted[button] += 1;
        }
    }
    let log = stage.play("super-mario", &script)?;
    let seen = [
        log.presses(|frame| frame.a),
        log.presses(|frame| frame.right),
        log.presses(|frame| frame.left),
    ];
    let lengths = |presses: &[Press]| {
        let frames = || presses.iter().map(|press| press.frames);
        (frames().min().unwrap_or(0), frames().max().unwrap_or(0))
    };
    eprintln!("\n{:.2} frames a second", log.rate_hz()?);
    for (name, (presses, wanted)) in ["A", "right", "left"].iter().zip(seen.iter().zip(wanted)) {
        let (shortest, longest) = lengths(presses);
        let seen = presses.len();
        eprintln!("{name:5} pressed {wanted}, seen {seen}: {shortest} to {longest} frames");
    }
    for (presses, wanted) in seen.iter().zip(wanted) {
        ensure!(
            presses.len() == wanted,
            "{wanted} presses, {} seen",
            presses.len()
        );
        ensure!(lengths(presses).1 <= LONGEST_FRAMES, "a press stuck");
    }
    Ok(())
}

/// Numbers that look random and are the same in each run (an LCG of Knuth's).
struct Lcg(u64);

impl Lcg {
    fn within(&mut self, range: Range<u32>) -> u32 {
        let factor = 6_364_136_223_846_793_005;
        self.0 = self
            .0
            .wrapping_mul(factor)
            .wrapping_add(1_442_695_040_888_963_407);
        let span = u64::from(range.end - range.start);
        range.start + ((self.0 >> 33) % span) as u32
    }
}

/// The mouse on the window's own pad, while the emulator has the keyboard: that pad takes no focus.
#[cfg(feature = "gui")]
fn window(stage: &mut Stage) -> Result<()> {
    let tools = Tools::find()?;
    let log = stage.play_in_window(&tools, &[SHORT_MS, LONG_MS, SHORT_MS, LONG_MS])?;
    let jumps = log.presses(|frame| frame.a);
    print_jumps(&jumps, log.rate_hz()?);
    let [short, long, short_again, long_again] = jumps.as_slice() else {
        bail!("4 presses of the mouse became {} jumps", jumps.len());
    };
    for (short, long) in [(short, long), (short_again, long_again)] {
        ensure!(
            long.height_px > short.height_px,
            "a long press rose {} px, a short one {} px",
            long.height_px,
            short.height_px
        );
    }
    Ok(())
}

fn press_lengths_ms() -> impl Iterator<Item = u32> {
    [SHORT_MS, LONG_MS].into_iter().cycle().take(JUMPS as usize)
}

fn jump_script() -> Script {
    let mut script = Script::default();
    let starts = (LEAD_MS..).step_by(JUMP_PERIOD_MS as usize);
    for (start_ms, press_ms) in starts.zip(press_lengths_ms()) {
        script.press(JUMP, start_ms, press_ms);
    }
    script
}

fn walk_script() -> Script {
    let [right_ms, left_ms, run_ms] = [0, 1, 2].map(|nth| LEAD_MS + nth * WALK_PERIOD_MS);
    let mut script = Script::default();
    script.press(RIGHT, right_ms, WALK_MS);
    script.press(LEFT, left_ms, WALK_MS);
    script.press(RUN, run_ms - RUN_MARGIN_MS, WALK_MS + 2 * RUN_MARGIN_MS);
    script.press(RIGHT, run_ms, WALK_MS);
    script
}

/// The jumps in a log of `jump_script`, one for each press.
fn jumps(log: &Log) -> Result<Vec<Press>> {
    let jumps = log.presses(|frame| frame.a);
    print_jumps(&jumps, log.rate_hz()?);
    ensure!(
        jumps.len() == JUMPS as usize,
        "{JUMPS} touches became {} presses of A",
        jumps.len()
    );
    Ok(jumps)
}

/// Jumps through which the game drew frame after frame, and how long each was pressed.
fn judged(jumps: &[Press]) -> Result<Vec<(&Press, u32)>> {
    let sound: Vec<(&Press, u32)> = jumps
        .iter()
        .zip(press_lengths_ms())
        .filter(|(jump, _)| jump.gap_ms < STALL_MS)
        .collect();
    ensure!(
        sound.len() >= JUDGED,
        "the game stalled in all but {} of {} jumps: the machine is too busy to judge by",
        sound.len(),
        jumps.len()
    );
    Ok(sound)
}

fn ensure_long_jumps_are_higher(jumps: &[Press]) -> Result<()> {
    let heights_px = |length_ms| {
        let of_length = move |(jump, press_ms): (&Press, u32)| {
            (press_ms == length_ms).then_some(jump.height_px)
        };
        jumps.iter().zip(press_lengths_ms()).filter_map(of_length)
    };
    let short_px = heights_px(SHORT_MS).max().context("no short jump")?;
    let long_px = heights_px(LONG_MS).min().context("no long jump")?;
    ensure!(
        long_px > short_px,
        "the lowest long jump rose {long_px} px, the highest short one {short_px} px"
    );
    Ok(())
}

fn frames(press: &Press) -> f64 {
    f64::from(u32::try_from(press.frames).unwrap_or(u32::MAX))
}

fn px_per_frame(walk: &Press) -> f64 {
    f64::from(walk.way_px) / frames(walk)
}

fn print_jumps(jumps: &[Press], rate_hz: f64) {
    eprintln!("\n{rate_hz:.2} frames a second\npress ms  frames of A  height px");
    for (jump, press_ms) in jumps.iter().zip(press_lengths_ms()) {
        eprintln!("{press_ms:8}  {:11}  {:9}", jump.frames, jump.height_px);
    }
}

fn print_walks(walks: &[Press]) {
    eprintln!("\nframes  way px  px a frame");
    for walk in walks {
        eprintln!(
            "{:6}  {:6}  {:10.2}",
            walk.frames,
            walk.way_px,
            px_per_frame(walk)
        );
    }
}
