//! `gelpad accuracy --real`: sensing under the disturbances that boards, pads and hands really bring.
//!
//! Each condition plays a session on pads that the model does not know: rest, then presses with rests between, with the
//! readings disturbed by name (`Disturbance`). The sensing is the one that plays. Counted are presses that are missed,
//! touches that no finger made, errors of place, and how long a touch outlives its finger.

mod board;
mod conditions;
mod hand;
mod play;
mod report;
mod surroundings;

pub use conditions::{Condition, Goal, conditions, own_conditions};
pub use hand::Hand;
pub use report::{ConditionFindings, RealFindings, TABLE_HEADER};
pub use surroundings::Surroundings;

use std::collections::BTreeMap;

use super::Bench;
use super::draws::Draws;
use super::found::{self, FOUND_FROM_FRAMES};
use super::sensed::Sensed;
use super::specimen::Specimen;
use crate::eit::PressedPad;
use crate::pad::{Pad, TouchSign};
use crate::study::{Slopes, StudyError, job};
use crate::touch::SensingBuilder;
use crate::types::PointMm;
use board::Board;
use hand::Drawn;
use play::{Played, Press, Solved, Stage};

/// How much is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Pads, each with its own random contacts and background.
    pub pads: usize,
    /// Presses on each pad.
    pub presses: usize,
    /// Length of a session on an untouched pad, s.
    pub untouched_s: usize,
}

impl Extent {
    /// A few minutes on two cores.
    pub const FULL: Self = Self {
        pads: 4,
        presses: 50,
        untouched_s: 600,
    };
    /// Some ten seconds.
    pub const QUICK: Self = Self {
        pads: 1,
        presses: 12,
        untouched_s: 30,
    };
}

/// Sessions that are played at the same time: enough for many cores, few enough that rows come out one after another.
const SESSIONS_AT_ONCE: usize = 8;

/// Frames before those from which a pad is found.
const SETTLING_FRAMES: usize = 200;

/// Added to the seed of the sessions for the readings that a pad is found from.
const FINDING: u64 = 1 << 32;

/// Plays all conditions in their order, and hands over each as soon as it is played.
///
/// # Errors
/// A pad that cannot be solved; what `on_condition` returns.
pub(super) fn play_all<E: From<StudyError>>(
    bench: &Bench,
    conditions: &[Condition],
    extent: Extent,
    mut on_condition: impl FnMut(ConditionFindings) -> Result<(), E>,
) -> Result<(), E> {
    let (mut solved, mut found) = (BTreeMap::new(), BTreeMap::new());
    for conditions in conditions.chunks(SESSIONS_AT_ONCE.div_ceil(extent.pads)) {
        solve_hands(bench, conditions, extent, &mut solved)?;
        find_pads(bench, conditions, extent, &solved, &mut found)?;
        let sessions: Vec<(&Condition, usize)> = conditions
            .iter()
            .flat_map(|condition| (0..extent.pads).map(move |pad| (condition, pad)))
            .collect();
        let played: Vec<Played> = job::solve_in_parallel(
            &sessions,
            |(condition, pad)| {
                let solved = &solved[&(key(condition), *pad)];
                let found = found[&(readings_key(condition), *pad)].as_ref();
                let seed = bench
                    .seed
                    .wrapping_mul(1_000_003)
                    .wrapping_add((condition.number * 64 + pad) as u64);
                Ok::<_, StudyError>(play::session(bench, condition, extent, solved, found, seed))
            },
            |_, _| (),
        )?;
        for (condition, played) in conditions.iter().zip(played.chunks(extent.pads)) {
            on_condition(ConditionFindings::new(condition, played))?;
        }
    }
    Ok(())
}

/// Hands and surroundings are compared by their text: their numbers are constants.
fn key(condition: &Condition) -> String {
    format!("{:?} {:?}", condition.hand, condition.surroundings)
}

/// What the readings of the untouched pad depend on beside the pad.
fn readings_key(condition: &Condition) -> String {
    let Condition {
        disturbances,
        snr_db,
        hand,
        ..
    } = condition;
    format!("{disturbances:?} {snr_db} {}", hand.is_on_model())
}

/// Finds the pads as the boards of these conditions read them, each once, and adds them to those found before.
fn find_pads(
    bench: &Bench,
    conditions: &[Condition],
    extent: Extent,
    solved: &BTreeMap<(String, usize), Solved>,
    found: &mut BTreeMap<(String, usize), Option<SensingBuilder>>,
) -> Result<(), StudyError> {
    let boards: BTreeMap<(String, usize), &Condition> = conditions
        .iter()
        .flat_map(|condition| {
            (0..extent.pads).map(move |pad| ((readings_key(condition), pad), condition))
        })
        .filter(|(board, _)| !found.contains_key(board))
        .collect();
    let boards: Vec<_> = boards.into_iter().collect();
    let new = job::solve_in_parallel(
        &boards,
        |((_, pad), condition)| {
            let rest = &solved[&(key(condition), *pad)].rest;
            let seed = bench
                .seed
                .wrapping_mul(1_000_003)
                .wrapping_add(FINDING + *pad as u64);
            find_pad(bench, condition, rest, seed)
        },
        |_, _| (),
    )?;
    found.extend(boards.into_iter().map(|(board, _)| board).zip(new));
    Ok(())
}

/// The pad as found by the first press, as the board of the condition reads it. A board that wakes up badly is awake by then.
fn find_pad(
    bench: &Bench,
    condition: &Condition,
    rest: &[f64],
    seed: u64,
) -> Result<Option<SensingBuilder>, StudyError> {
    let mut board = Board::new(condition, rest, &bench.pad.protocol, seed);
    let drawn = bench.sensing.builder();
    let mut sensed = Sensed::new(bench.sensing.new_detector(), drawn);
    let mut frames = Vec::with_capacity(FOUND_FROM_FRAMES);
    for index in 0..SETTLING_FRAMES + FOUND_FROM_FRAMES {
        let frame = board.read(rest);
        sensed.process(&frame);
        if index >= SETTLING_FRAMES {
            frames.push(frame.volts);
        }
    }
    found::find(&bench.pad, drawn, &frames, &sensed.left_out())
}

/// Solves the hands of these conditions on every pad, each once in its surroundings, and adds them to those solved before.
fn solve_hands(
    bench: &Bench,
    conditions: &[Condition],
    extent: Extent,
    solved: &mut BTreeMap<(String, usize), Solved>,
) -> Result<(), StudyError> {
    let hands: BTreeMap<(String, usize), &Condition> = conditions
        .iter()
        .flat_map(|condition| (0..extent.pads).map(move |pad| ((key(condition), pad), condition)))
        .filter(|(hand, _)| !solved.contains_key(hand))
        .collect();
    let hands: Vec<_> = hands.into_iter().collect();
    let new = job::solve_in_parallel(
        &hands,
        |((_, pad), condition)| solve(bench, condition, *pad, extent),
        |_, _| (),
    )?;
    solved.extend(hands.into_iter().map(|(hand, _)| hand).zip(new));
    Ok(())
}

/// Solves a pad at rest and under each press of a hand. Pad and presses depend on the seed and the pad's number only.
fn solve(
    bench: &Bench,
    condition: &Condition,
    pad: usize,
    extent: Extent,
) -> Result<Solved, StudyError> {
    let (hand, surroundings) = (condition.hand, condition.surroundings);
    let specimen = if hand.is_on_model() {
        Specimen::ideal(&bench.pad)?
    } else {
        Specimen::random(
            &bench.pad,
            &mut Draws::new(&bench.pad, bench.seed, 1000 + pad as u64),
        )?
    };
    let mut draws = Draws::new(&bench.pad, bench.seed, 2000 + pad as u64);
    let count = if hand.is_untouched() {
        0
    } else {
        extent.presses * hand.rhythm().presses
    };
    let mut presses = Vec::with_capacity(count);
    while presses.len() < count {
        let drawn = hand.draw(&bench.pad, bench.scale, &mut draws)?;
        let fits = |place: &PointMm| surroundings.leaves_room(&bench.pad, bench.scale, *place);
        if !drawn.iter().flat_map(|now| &now.centres_mm).all(fits) {
            continue;
        }
        let stages = drawn
            .into_iter()
            .map(|now| solve_stage(&bench.pad, &specimen, now))
            .collect::<Result<_, StudyError>>()?;
        presses.push(Press { stages });
    }
    Ok(Solved {
        surrounded: surroundings.solve(&bench.pad, bench.scale, &specimen)?,
        rest: specimen.rest,
        presses,
    })
}

/// Solves a pad under a hand at one moment.
fn solve_stage(pad: &Pad, specimen: &Specimen, drawn: Drawn) -> Result<Stage, StudyError> {
    let fields = specimen.touched(&drawn.factor)?;
    let volts = fields.voltages(&pad.protocol);
    let bounds = if drawn.presses.is_empty() {
        Vec::new()
    } else {
        let pressed = PressedPad {
            model: &specimen.model,
            fields: &fields,
            background: &specimen.background,
            presses: &drawn.presses,
            sign: TouchSign::Rise,
        };
        let deviations: Vec<f64> = volts.iter().map(|volt| volt.abs()).collect();
        let bounds = Slopes::new(&pressed, pad).bounds(&deviations);
        bounds.unwrap_or_default()
    };
    Ok(Stage {
        centres_mm: drawn.centres_mm,
        volts,
        bounds,
    })
}
