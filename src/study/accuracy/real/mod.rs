//! `gelpad accuracy --real`: sensing under the disturbances that boards, pads and hands really bring.
//!
//! Each condition plays a session on pads that the model does not know: rest, then presses with rests between, with the
//! readings disturbed by name (`Disturbance`). The sensing is the one that plays. Counted are presses that are missed,
//! touches that no finger made, errors of place, and how long a touch outlives its finger.

mod conditions;
mod hand;
mod play;
mod report;
mod surroundings;

pub use conditions::{Condition, Goal, conditions, own_conditions};
pub use hand::Hand;
pub use report::{ConditionFindings, RealFindings};
pub use surroundings::Surroundings;

use std::collections::BTreeMap;

use super::Bench;
use super::draws::Draws;
use super::specimen::Specimen;
use crate::study::{StudyError, job};
use crate::types::PointMm;
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

/// Plays all conditions.
///
/// # Errors
/// A pad that cannot be solved.
pub(super) fn play_all(
    bench: &Bench,
    conditions: &[Condition],
    extent: Extent,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Vec<ConditionFindings>, StudyError> {
    let solved = solve_hands(bench, conditions, extent)?;
    let runs: Vec<(usize, usize)> = (0..conditions.len())
        .flat_map(|condition| (0..extent.pads).map(move |pad| (condition, pad)))
        .collect();
    let played: Vec<Played> = job::solve_in_parallel(
        &runs,
        |(index, pad)| {
            let condition = &conditions[*index];
            let solved = &solved[&(key(condition), *pad)];
            let seed = bench
                .seed
                .wrapping_mul(1_000_003)
                .wrapping_add((index * 64 + pad) as u64);
            play::session(bench, condition, extent, solved, seed)
        },
        progress,
    )?;
    Ok(conditions
        .iter()
        .enumerate()
        .map(|(index, condition)| {
            let own: Vec<&Played> = runs
                .iter()
                .zip(&played)
                .filter(|((run, _), _)| *run == index)
                .map(|(_, played)| played)
                .collect();
            ConditionFindings::of(condition, &own)
        })
        .collect())
}

/// Hands and surroundings are compared by their text: their numbers are constants.
fn key(condition: &Condition) -> String {
    format!("{:?} {:?}", condition.hand, condition.surroundings)
}

/// Solves every hand in its surroundings on every pad, once.
fn solve_hands(
    bench: &Bench,
    conditions: &[Condition],
    extent: Extent,
) -> Result<BTreeMap<(String, usize), Solved>, StudyError> {
    let hands: BTreeMap<String, &Condition> = conditions
        .iter()
        .map(|condition| (key(condition), condition))
        .collect();
    let jobs: Vec<(String, &Condition, usize)> = hands
        .into_iter()
        .flat_map(|(key, condition)| (0..extent.pads).map(move |pad| (key.clone(), condition, pad)))
        .collect();
    let solved = job::solve_in_parallel(
        &jobs,
        |(_, condition, pad)| solve(bench, condition, *pad, extent),
        |_, _| (),
    )?;
    let keys = jobs.into_iter().map(|(key, _, pad)| (key, pad));
    Ok(keys.zip(solved).collect())
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
        if !drawn.iter().flat_map(|(centres, _)| centres).all(fits) {
            continue;
        }
        let stages = drawn
            .into_iter()
            .map(|(centres_mm, factor)| {
                let volts = specimen.touched(factor)?.voltages(&bench.pad.protocol);
                Ok(Stage { centres_mm, volts })
            })
            .collect::<Result<_, StudyError>>()?;
        presses.push(Press { stages });
    }
    Ok(Solved {
        surrounded: surroundings.solve(&bench.pad, bench.scale, &specimen)?,
        rest: specimen.rest,
        presses,
    })
}
