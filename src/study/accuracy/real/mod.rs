//! `gelpad accuracy --real`: sensing under the disturbances that boards, pads and hands really bring.
//!
//! Each condition plays a session on pads that the model does not know: rest, then presses with rests between, with the
//! readings disturbed by name (`Disturbance`). The sensing is the one that plays. Counted are presses that are missed,
//! touches that no finger made, errors of place, and how long a touch outlives its finger.

mod conditions;
mod hand;
mod play;
mod report;

pub use conditions::{Condition, Goal, conditions, own_conditions};
pub use hand::Hand;
pub use report::{ConditionFindings, RealFindings};

use std::collections::BTreeMap;

use super::Bench;
use super::draws::Draws;
use super::specimen::Specimen;
use crate::study::{StudyError, job};
use play::{Played, Press};

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

/// Presses of one hand on one pad, solved once for all conditions.
struct Solved {
    rest: Vec<f64>,
    presses: Vec<Press>,
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
            let solved = &solved[&(key(condition.hand), *pad)];
            let seed = bench
                .seed
                .wrapping_mul(1_000_003)
                .wrapping_add((index * 64 + pad) as u64);
            play::session(
                bench,
                condition,
                extent,
                &solved.rest,
                &solved.presses,
                seed,
            )
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

/// Hands are compared by their text: their numbers are constants.
fn key(hand: Hand) -> String {
    format!("{hand:?}")
}

/// Solves every hand of the conditions on every pad, once.
fn solve_hands(
    bench: &Bench,
    conditions: &[Condition],
    extent: Extent,
) -> Result<BTreeMap<(String, usize), Solved>, StudyError> {
    let hands: BTreeMap<String, Hand> = conditions
        .iter()
        .map(|condition| (key(condition.hand), condition.hand))
        .collect();
    let jobs: Vec<(String, Hand, usize)> = hands
        .into_iter()
        .flat_map(|(key, hand)| (0..extent.pads).map(move |pad| (key.clone(), hand, pad)))
        .collect();
    let solved = job::solve_in_parallel(
        &jobs,
        |(_, hand, pad)| solve(bench, *hand, *pad, extent),
        |_, _| (),
    )?;
    let keys = jobs.into_iter().map(|(key, _, pad)| (key, pad));
    Ok(keys.zip(solved).collect())
}

/// Solves a pad at rest and under each press of a hand. Pad and presses depend on the seed and the pad's number only.
fn solve(bench: &Bench, hand: Hand, pad: usize, extent: Extent) -> Result<Solved, StudyError> {
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
        extent.presses * hand.presses_and_pause().0
    };
    let presses = (0..count)
        .map(|_| {
            let (centres_mm, factor) = hand.draw(&bench.pad, bench.scale, &mut draws)?;
            let volts = specimen.touched(factor)?.voltages(&bench.pad.protocol);
            Ok(Press { centres_mm, volts })
        })
        .collect::<Result<_, StudyError>>()?;
    Ok(Solved {
        rest: specimen.rest,
        presses,
    })
}
