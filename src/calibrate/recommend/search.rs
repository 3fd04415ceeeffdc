//! Searches the settings with which most presses come out right.
//!
//! Coordinate ascent: each setting in turn takes its best value while the others are fixed, until nothing improves. There are
//! several starts, since joining re-touches only helps together with a longer `long_ms`. Delays have a cost.

use std::collections::BTreeMap;

use super::overlay::RecommendedSettings;
use super::scorer::{RecommendError, TrialScorer};
use super::trial::PressTrial;

/// Factors on the times of each press, since no two presses are the same.
const PACES: [f64; 5] = [0.8, 0.9, 1.0, 1.1, 1.25];
/// Most rounds over all settings.
const MOST_ROUNDS: usize = 4;

/// Candidate values.
pub(super) const LONG_MS: &[u32] = &[
    120, 160, 200, 250, 300, 350, 400, 500, 600, 700, 800, 1000, 1200, 1500,
];
const TREMOR_MS: &[u32] = &[0, 40, 60, 80, 100, 130, 160, 200, 250];
const TREMOR_MM: &[u32] = &[0, 6, 10, 15, 20, 25, 30];
/// Least distance where re-touches are joined.
const FIRST_TREMOR_MM: u32 = 15;
const SLOW_KEYS_MS: &[u32] = &[0, 40, 60, 80, 100, 130, 160, 200, 250, 300];
const BOUNCE_KEYS_MS: &[u32] = &[0, 60, 100, 150, 200, 250, 300, 400];

/// Cost of a delay of 100 ms, as a share of presses: of a press, a release, a repeated press; and of sending a press only when
/// its length is known.
const PRESS_COST: f64 = 0.03;
const RELEASE_COST: f64 = 0.01;
const REPEAT_COST: f64 = 0.005;
const DECIDED_COST: f64 = 0.05;

/// Cost of the delays of settings, as a share of presses.
fn cost(overlay: &RecommendedSettings) -> f64 {
    let hundreds = |ms: u32| f64::from(ms) / 100.0;
    PRESS_COST * hundreds(overlay.slow_keys_ms)
        + RELEASE_COST * hundreds(overlay.tremor_ms)
        + REPEAT_COST * hundreds(overlay.bounce_keys_ms)
        + if overlay.when_decided {
            DECIDED_COST
        } else {
            0.0
        }
}

/// Sets one setting.
type Setter = fn(&mut RecommendedSettings, u32);

/// The settings in the order of the search, each with its candidate values.
const COORDINATES: &[(Setter, &[u32])] = &[
    (|o, ms| o.long_ms = ms, LONG_MS),
    (|o, flag| o.when_decided = flag == 1, &[0, 1]),
    (
        |o, ms| {
            o.tremor_ms = ms;
            o.tremor_mm = o.tremor_mm.max(FIRST_TREMOR_MM);
        },
        TREMOR_MS,
    ),
    (|o, mm| o.tremor_mm = mm, TREMOR_MM),
    (|o, ms| o.slow_keys_ms = ms, SLOW_KEYS_MS),
    (|o, ms| o.bounce_keys_ms = ms, BOUNCE_KEYS_MS),
];

/// The best settings for presses; `plain` are those of the profile.
pub(super) fn best(
    judge: &TrialScorer<'_>,
    trials: &[PressTrial],
    plain: RecommendedSettings,
) -> Result<RecommendedSettings, RecommendError> {
    let trials: Vec<PressTrial> = trials.iter().map(PressTrial::thinned).collect();
    search_settings(plain, &mut |overlay| {
        let mut value = -cost(overlay);
        for pace in PACES {
            let score = judge.score_at_pace(&trials, Some(overlay), pace)?;
            value += score.value() / score.requested.max(1) as f64 / PACES.len() as f64;
        }
        Ok(value)
    })
}

/// Settings of the highest value, by coordinate ascent from several starts.
///
/// # Errors
/// Those of `evaluate`.
pub fn search_settings<E>(
    plain: RecommendedSettings,
    evaluate: &mut impl FnMut(&RecommendedSettings) -> Result<f64, E>,
) -> Result<RecommendedSettings, E> {
    // The same settings occur many times.
    let mut known: BTreeMap<[u32; 6], f64> = BTreeMap::new();
    let value = &mut |overlay: &RecommendedSettings| match known.get(&overlay.search_key()) {
        Some(value) => Ok(*value),
        None => {
            let value = evaluate(overlay)?;
            known.insert(overlay.search_key(), value);
            Ok(value)
        }
    };
    let mut best: Option<(f64, RecommendedSettings)> = None;
    for start in starts(&plain) {
        let (reached, overlay) = climb_from(start, value)?;
        if best.as_ref().is_none_or(|(value, _)| reached > *value) {
            best = Some((reached, overlay));
        }
    }
    Ok(best.map_or(plain, |(_, overlay)| overlay))
}

/// Starts of the search: the profile's settings, then typical settings for trembling, slow and brushing hands.
fn starts(plain: &RecommendedSettings) -> [RecommendedSettings; 5] {
    let joined = RecommendedSettings {
        tremor_ms: 130,
        tremor_mm: 20,
        long_ms: 350,
        ..plain.clone()
    };
    let slow = RecommendedSettings {
        long_ms: 700,
        when_decided: true,
        ..plain.clone()
    };
    let both = RecommendedSettings {
        tremor_ms: 160,
        tremor_mm: 25,
        slow_keys_ms: 60,
        ..slow.clone()
    };
    let careful = RecommendedSettings {
        slow_keys_ms: 100,
        long_ms: 500,
        ..both.clone()
    };
    [plain.clone(), joined, slow, both, careful]
}

/// Improves one setting after the other until a round brings nothing.
fn climb_from<E>(
    start: RecommendedSettings,
    value: &mut impl FnMut(&RecommendedSettings) -> Result<f64, E>,
) -> Result<(f64, RecommendedSettings), E> {
    let mut here = start;
    let mut reached = value(&here)?;
    for _ in 0..MOST_ROUNDS {
        let before = reached;
        for (set, values) in COORDINATES {
            let candidates: Vec<(f64, RecommendedSettings)> = values
                .iter()
                .map(|wanted| {
                    let mut other = here.clone();
                    set(&mut other, *wanted);
                    if other.tremor_ms == 0 {
                        other.tremor_mm = 0;
                    }
                    value(&other).map(|value| (value, other))
                })
                .collect::<Result<_, E>>()?;
            if let Some((value, overlay)) = highest(&candidates)
                && value > reached
            {
                (reached, here) = (value, overlay.clone());
            }
        }
        if reached <= before {
            break;
        }
    }
    Ok((reached, here))
}

/// The candidate with the highest value; of the first run of equal ones, the middle one.
fn highest(candidates: &[(f64, RecommendedSettings)]) -> Option<(f64, &RecommendedSettings)> {
    const EQUAL: f64 = 1e-9;
    let top = candidates
        .iter()
        .map(|(value, _)| *value)
        .max_by(f64::total_cmp)?;
    let is_top = |at: &usize| candidates[*at].0 >= top - EQUAL;
    let first = (0..candidates.len()).find(is_top)?;
    let run = (first..candidates.len()).take_while(is_top).count();
    let (value, overlay) = &candidates[first + (run - 1) / 2];
    Some((*value, overlay))
}
