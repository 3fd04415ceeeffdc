//! Plays a real game from end to end: touches on a simulated pad go through the gelpad binary, its key events
//! through an X server to the emulator fceux, which plays a game of our own (`game/jump.s`). The game's
//! memory shows for every frame which buttons it saw and what the figure did.
//!
//! The test does not look into gelpad: a press that is late, short or missing shows as a lower jump, as it
//! would to a player.
//!
//! Needs Xvfb, xdotool, cc65, fceux and bash. If one is missing, the trials are ignored with the reason as
//! their kind; with `GELPAD_TEST_ALL=1` they fail. `GELPAD_JUMPS` and `GELPAD_PRESSES` set how often is
//! jumped and pressed; the defaults are small samples.

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

// Places in the regions of the super-mario profiles, mm.
const JUMP: Place = Place { x_mm: 80, y_mm: 50 };
const RUN: Place = Place { x_mm: 75, y_mm: 9 };
const LEFT: Place = Place { x_mm: 13, y_mm: 57 };
const RIGHT: Place = Place { x_mm: 37, y_mm: 57 };

/// Well below and well above the 200 ms that separate short from long.
const SHORT_MS: u32 = 80;
const LONG_MS: u32 = 600;
/// Number of presses without `GELPAD_JUMPS`, alternately short and long.
const JUMPS: usize = 6;
/// Time between two presses: the highest jump takes 0.9 s.
const JUMP_PERIOD_MS: u32 = 1200;
/// Time before the first touch, for the reference.
const LEAD_MS: u32 = 1000;

/// A touch starts and ends at any time between two frames of the pad, and a key at any time between two
/// frames of the game: each may cost a frame.
const DIRECT_TOLERANCE_FRAMES: f64 = 2.0;
/// Lengths of the classified profile, in frames of the game, and their tolerance from the game's own sampling
/// of the key.
const CLASSIFIED_SHORT_FRAMES: usize = 5;
const CLASSIFIED_LONG_FRAMES: usize = 32;
const CLASSIFIED_TOLERANCE_FRAMES: usize = 1;

/// Number of random presses without `GELPAD_PRESSES`, and range of their length and of the pause after each.
const PRESSES: usize = 60;
const PRESS_MS: Range<u32> = 34..201;
const PAUSE_MS: Range<u32> = 50..201;
/// Longest time that the game may see a press, frames: no press sticks.
const LONGEST_FRAMES: usize = 16;

/// A game that draws no frame for this time, ms, has stalled: what it sees of a press then does not depend on
/// gelpad.
const STALL_MS: f64 = 30.0;
/// Share of jumps that must be free of stalls for a judgement.
const JUDGED_SHARE: f64 = 2.0 / 3.0;

const WALK_MS: u32 = 600;
const WALK_PERIOD_MS: u32 = 1200;
/// B is held for this long before and after the arrow key.
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

/// A trial with its own stage, or an ignored one if tools are missing.
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

/// Plays, and adds the emulator's messages to an error.
fn on_stage(tools: &Tools, play: fn(&mut Stage) -> Result<()>) -> Result<()> {
    let mut stage = Stage::start(tools)?;
    play(&mut stage).map_err(|error| anyhow!("{error:#}\n{}", stage.emulator_messages()))
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

/// The paper's short and long press: two heights of jump, independent of the touch.
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

/// Each arrow walks in its direction, and B with an arrow runs.
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

/// Two fingers press at random: the game sees each press once, and none sticks.
fn presses(stage: &mut Stage) -> Result<()> {
    let count = count("GELPAD_PRESSES", PRESSES);
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

/// A pseudo-random sequence that is the same in each run (Knuth's LCG).
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

/// The mouse on the window's own pad while the emulator has the keyboard focus, which that pad does not take.
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

/// A count from the environment, or its default.
fn count(variable: &str, default: usize) -> usize {
    let text = std::env::var(variable).ok();
    text.and_then(|text| text.parse().ok()).unwrap_or(default)
}

fn press_lengths_ms() -> impl Iterator<Item = u32> {
    let jumps = count("GELPAD_JUMPS", JUMPS);
    [SHORT_MS, LONG_MS].into_iter().cycle().take(jumps)
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
    let touches = press_lengths_ms().count();
    ensure!(
        jumps.len() == touches,
        "{touches} touches became {} presses of A",
        jumps.len()
    );
    Ok(jumps)
}

/// The jumps without a stall of the game, with the length of their press.
fn judged(jumps: &[Press]) -> Result<Vec<(&Press, u32)>> {
    let without_stall: Vec<(&Press, u32)> = jumps
        .iter()
        .zip(press_lengths_ms())
        .filter(|(jump, _)| jump.gap_ms < STALL_MS)
        .collect();
    ensure!(
        without_stall.len() as f64 >= JUDGED_SHARE * jumps.len() as f64,
        "the game stalled in all but {} of {} jumps: the machine is too busy to judge by",
        without_stall.len(),
        jumps.len()
    );
    Ok(without_stall)
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
