//! The settings under which most presses come out as meant: found by trying.
//!
//! One setting after the other is set to the best of its values, the others held, until nothing gets better; from several
//! beginnings, since joining re-touches only helps together with a longer `long_ms`. Of equals the one with less delay wins.

use std::collections::BTreeMap;

use super::{Judge, Overlay, RecommendError, Trial};

/// Each press is tried this many times as slow: nobody presses twice alike.
const PACES: [f64; 5] = [0.8, 0.9, 1.0, 1.1, 1.25];
/// A press that nobody meant is as bad as so many that do not come out.
const WRONG_WORTH: f64 = 2.0;
/// Rounds over all settings, at most.
const MOST_ROUNDS: usize = 4;

/// Values that are tried.
pub(super) const LONG_MS: &[u32] = &[
    120, 160, 200, 250, 300, 350, 400, 500, 600, 700, 800, 1000, 1200, 1500,
];
const TREMOR_MS: &[u32] = &[0, 40, 60, 80, 100, 130, 160, 200, 250];
const TREMOR_MM: &[u32] = &[0, 6, 10, 15, 20, 25, 30];
/// With joining comes this distance to begin with.
const FIRST_TREMOR_MM: u32 = 15;
const SLOW_KEYS_MS: &[u32] = &[0, 40, 60, 80, 100, 130, 160, 200, 250, 300];
const BOUNCE_KEYS_MS: &[u32] = &[0, 60, 100, 150, 200, 250, 300, 400];

/// Share of presses that a delay of 100 ms must be worth: of a press, of a release, of a re-press; and that it is worth to
/// have a press at once instead of when its length is known.
const PRESS_COST: f64 = 0.03;
const RELEASE_COST: f64 = 0.01;
const AGAIN_COST: f64 = 0.005;
const DECIDED_COST: f64 = 0.05;

/// What is paid for a setting, as a share of presses.
fn cost(overlay: &Overlay) -> f64 {
    let hundreds = |ms: u32| f64::from(ms) / 100.0;
    PRESS_COST * hundreds(overlay.slow_keys_ms)
        + RELEASE_COST * hundreds(overlay.tremor_ms)
        + AGAIN_COST * hundreds(overlay.bounce_keys_ms)
        + if overlay.when_decided {
            DECIDED_COST
        } else {
            0.0
        }
}

/// A change of one setting.
type Change = fn(&mut Overlay, u32);

/// The settings in the order in which they are tried, each with its values.
const COORDINATES: &[(Change, &[u32])] = &[
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

/// The best settings for presses, `plain` being what the profile has by itself.
pub(super) fn best(
    judge: &Judge<'_>,
    trials: &[Trial],
    plain: Overlay,
) -> Result<Overlay, RecommendError> {
    let trials: Vec<Trial> = trials.iter().map(Trial::thinned).collect();
    climb(plain, &mut |overlay| {
        let mut value = -cost(overlay);
        for pace in PACES {
            let outcome = judge.outcome_at(&trials, Some(overlay), pace)?;
            let wrong = WRONG_WORTH * outcome.wrong as f64;
            value +=
                (outcome.right as f64 - wrong) / outcome.asked.max(1) as f64 / PACES.len() as f64;
        }
        Ok(value)
    })
}

/// Climbs from several beginnings to settings of the highest value.
///
/// # Errors
/// What the value has.
pub fn climb<E>(
    plain: Overlay,
    ask: &mut impl FnMut(&Overlay) -> Result<f64, E>,
) -> Result<Overlay, E> {
    // The same settings come up again and again.
    let mut known: BTreeMap<[u32; 6], f64> = BTreeMap::new();
    let value = &mut |overlay: &Overlay| match known.get(&overlay.key()) {
        Some(value) => Ok(*value),
        None => {
            let value = ask(overlay)?;
            known.insert(overlay.key(), value);
            Ok(value)
        }
    };
    let joined = Overlay {
        tremor_ms: 130,
        tremor_mm: 20,
        long_ms: 350,
        ..plain.clone()
    };
    let slow = Overlay {
        long_ms: 700,
        when_decided: true,
        ..plain.clone()
    };
    let both = Overlay {
        tremor_ms: 160,
        tremor_mm: 25,
        slow_keys_ms: 60,
        ..slow.clone()
    };
    let careful = Overlay {
        slow_keys_ms: 100,
        long_ms: 500,
        ..both.clone()
    };
    let mut best: Option<(f64, Overlay)> = None;
    for start in [plain, joined, slow, both, careful] {
        let mut here = start;
        let mut reached = value(&here)?;
        for _ in 0..MOST_ROUNDS {
            let before = reached;
            for (change, values) in COORDINATES {
                let tried: Vec<(f64, Overlay)> = values
                    .iter()
                    .map(|wanted| {
                        let mut other = here.clone();
                        change(&mut other, *wanted);
                        if other.tremor_ms == 0 {
                            other.tremor_mm = 0;
                        }
                        value(&other).map(|value| (value, other))
                    })
                    .collect::<Result<_, E>>()?;
                if let Some((value, overlay)) = highest(&tried)
                    && value > reached
                {
                    (reached, here) = (value, overlay.clone());
                }
            }
            if reached <= before {
                break;
            }
        }
        if best.as_ref().is_none_or(|(value, _)| reached > *value) {
            best = Some((reached, here));
        }
    }
    Ok(best.map_or_else(|| unreachable!("five beginnings"), |(_, overlay)| overlay))
}

/// The highest of values along one setting; of the first run of equals, the middle one.
fn highest(tried: &[(f64, Overlay)]) -> Option<(f64, &Overlay)> {
    const EQUAL: f64 = 1e-9;
    let top = tried
        .iter()
        .map(|(value, _)| *value)
        .max_by(f64::total_cmp)?;
    let is_top = |at: &usize| tried[*at].0 >= top - EQUAL;
    let first = (0..tried.len()).find(is_top)?;
    let run = (first..tried.len()).take_while(is_top).count();
    let (value, overlay) = &tried[first + (run - 1) / 2];
    Some((*value, overlay))
}
