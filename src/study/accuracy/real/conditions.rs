//! The conditions of `gelpad accuracy --real`: what disturbs the readings, which hand presses, and which goal is set.

use super::hand::Hand;
use super::surroundings::Surroundings;
use crate::source::Disturbance;

/// One row of the table.
#[derive(Clone, Debug)]
pub struct Condition {
    /// Its place in the whole table, from 0: its random numbers follow from it, so that it ends alike alone and among others.
    pub number: usize,
    /// Its name in tables.
    pub name: &'static str,
    /// What disturbs the readings.
    pub disturbances: Vec<Disturbance>,
    /// White noise beside it, dB.
    pub snr_db: f64,
    /// What presses.
    pub hand: Hand,
    /// What happens around the fingers.
    pub surroundings: Surroundings,
    /// What is to be reached.
    pub goal: Goal,
}

/// What is to be reached; `None` where nothing is asked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// Share of presses not seen in their first ten frames.
    pub missed: Option<f64>,
    /// Share of presses with the right number of touches.
    pub right: Option<f64>,
    /// Mean error of place where a finger is first found, mm.
    pub mean_mm: Option<f64>,
    /// Mean error of place in the press's last frame, mm.
    pub held_mm: Option<f64>,
    /// Touches that no finger made, in all.
    pub false_touches: Option<usize>,
    /// Longest time for which a touch outlives its finger, or lasts without one, ms.
    pub longest_ms: Option<f64>,
}

/// Name, disturbances, white noise in dB, hand and goal of a condition.
type Row = (&'static str, &'static str, f64, Hand, Goal);

/// Nearly no press is missed, no touch false.
const USUAL: Goal = goal(Some(0.01), None, Some(0));
/// No touch without a finger.
const NONE_FALSE: Goal = goal(None, None, Some(0));
/// A spike makes no lasting touch.
const SPIKY: Goal = Goal {
    longest_ms: Some(50.0),
    ..goal(Some(0.01), None, None)
};

/// Every condition, in the order of the table.
#[rustfmt::skip]
const ROWS: &[Row] = &[
    ("as the model assumes, 60 dB", "", 60.0, Hand::Finger, USUAL),
    ("pad = model, 80 dB", "", 80.0, Hand::FingerOnModel, goal(Some(0.0), Some(0.06), None)),
    ("40 dB, held for 50 ms", "", 40.0, Hand::ShortFinger, held(0.6)),
    ("slide at 300 mm/s", "", 60.0, Hand::Slide(300.0), Goal { right: Some(0.98), ..held(0.6) }),
    ("slide at 600 mm/s", "", 60.0, Hand::Slide(600.0), Goal { right: Some(0.95), ..held(1.0) }),
    ("two neighbouring electrodes lost", "lost-pair", 60.0, Hand::Finger, goal(Some(0.1), None, Some(1))),
    ("ADC of 12 bits, 70 dB", "adc:12", 70.0, Hand::Finger, goal(Some(0.02), Some(0.5), None)),
    ("ADC of 10 bits, 70 dB", "adc:10", 70.0, Hand::Finger, goal(Some(0.1), None, None)),
    ("common gain, 60 dB", "gain:60", 90.0, Hand::Finger, goal(Some(0.005), Some(0.25), None)),
    ("common gain at rest, 50 dB", "gain:50", 90.0, Hand::Untouched, NONE_FALSE),
    ("noise per drive, 50 dB", "drive:50", 90.0, Hand::Finger, goal(Some(0.01), Some(0.4), None)),
    ("noise per drive, 40 dB", "drive:40", 90.0, Hand::Finger, goal(Some(0.01), Some(1.0), None)),
    ("noise per drive at rest, 40 dB", "drive:40", 90.0, Hand::Untouched, NONE_FALSE),
    ("1/f noise at rest, 40 dB", "flicker:40", 70.0, Hand::Untouched, goal(None, None, Some(1))),
    ("one channel 10 % noisy", "noisy-channel:0.1", 60.0, Hand::Untouched, goal(None, None, Some(1))),
    ("one channel reads 0", "dead-channel", 60.0, Hand::Untouched, goal(None, None, Some(1))),
    ("mains ripple of 0.3 %", "mains:0.003", 60.0, Hand::Untouched, goal(None, None, Some(1))),
    ("spikes of 0.3 in 1 % of frames", "spikes:0.3", 60.0, Hand::Finger, SPIKY),
    ("spikes of 5 in 1 % of frames", "spikes:5", 60.0, Hand::Finger, SPIKY),
    ("surges of +30 %", "surge:0.3", 60.0, Hand::Finger, SPIKY),
    ("surges of -50 %", "surge:-0.5", 60.0, Hand::Finger, SPIKY),
    ("second frame x 0", "bad-start:0", 60.0, Hand::Finger, USUAL),
    ("second frame x 3", "bad-start:3", 60.0, Hand::Finger, USUAL),
    ("second frame x -1", "bad-start:-1", 60.0, Hand::Finger, USUAL),
    ("second frame garbage", "garbage-start", 60.0, Hand::Finger, USUAL),
    ("one frame x 1.6 in rest", "bad-frame:1.6", 60.0, Hand::Finger, USUAL),
    ("one frame x 10 in rest", "bad-frame:10", 60.0, Hand::Finger, USUAL),
    ("first ten frames identical", "repeated-start:10", 60.0, Hand::Finger, USUAL),
    ("gain step of 20 %", "gain-step:0.2", 60.0, Hand::Finger, goal(Some(0.02), None, Some(1))),
    ("unplugged for a second", "unplugged:1", 60.0, Hand::Finger, goal(Some(0.01), None, Some(1))),
    ("plugged in again, a quarter turn on", "turned:4", 60.0, Hand::Finger, goal(Some(0.01), Some(0.35), Some(1))),
    ("plugged in again, one electrode on", "turned:1", 60.0, Hand::Finger, goal(Some(0.01), Some(0.35), Some(1))),
    ("plugged in again, mirrored", "mirrored:0", 60.0, Hand::Finger, goal(Some(0.01), Some(0.35), Some(1))),
    ("falling touches", "", 60.0, Hand::Falling, USUAL),
    ("after a finger that lay there", "", 60.0, Hand::FingerAfterLying, USUAL),
    ("0 to 2 mm from the edge", "", 60.0, Hand::Edge(0.0, 2.0), goal(Some(0.05), None, Some(0))),
    ("2 to 4 mm from the edge", "", 60.0, Hand::Edge(2.0, 4.0), goal(Some(0.01), None, Some(0))),
    ("corner", "", 60.0, Hand::Corner, goal(Some(0.03), None, Some(0))),
    ("over an electrode", "", 60.0, Hand::Electrode, goal(Some(0.03), None, Some(0))),
    ("ellipse 12 x 6 mm", "", 60.0, Hand::Ellipse(12.0, 6.0), right(0.97)),
    ("ellipse 15 x 6 mm", "", 60.0, Hand::Ellipse(15.0, 6.0), right(0.95)),
    ("annulus", "", 60.0, Hand::Annulus, right(0.95)),
    ("radius 15 mm", "", 60.0, Hand::Radius(15.0), goal(None, Some(0.4), None)),
    ("rise of 10 %", "", 60.0, Hand::Rise(0.1), goal(None, Some(0.8), None)),
    ("radius 3 mm", "", 60.0, Hand::Radius(3.0), goal(Some(0.18), None, None)),
    ("radius 4 mm", "", 60.0, Hand::Radius(4.0), goal(Some(0.05), None, None)),
    ("pairs 12 mm apart", "", 60.0, Hand::Pair(12.0), right(0.6)),
    ("pairs 14 mm apart", "", 60.0, Hand::Pair(14.0), right(0.95)),
    ("three fingers", "", 60.0, Hand::Several(3), right(0.99)),
    ("three fingers after fast touches", "", 60.0, Hand::SeveralAfterDrumming(3), right(0.99)),
    ("five fingers", "", 60.0, Hand::Several(5), right(0.95)),
    ("six fingers", "", 60.0, Hand::Several(6), right(0.85)),
    ("any of these, 500 ms after the lift", "", 60.0, Hand::Any { falls: false }, goal(None, None, None)),
    ("the same, falling", "", 60.0, Hand::Any { falls: true }, goal(None, None, None)),
];

/// Fingers while something happens around them, at 60 dB. The heel may be one touch on each of the four pads.
#[rustfmt::skip]
const SURROUNDED: &[(&str, Surroundings, Hand, Goal)] = &[
    ("beside the heel of the hand", Surroundings::Heel, Hand::Finger, goal(Some(0.1), None, Some(4))),
    ("a pad that bends by 1 %", Surroundings::Bending, Hand::Finger, goal(Some(0.02), None, Some(1))),
    ("an edge that dries by 10 %", Surroundings::DryingEdge, Hand::Finger, goal(Some(0.02), None, Some(1))),
];

const fn goal(missed: Option<f64>, mean_mm: Option<f64>, false_touches: Option<usize>) -> Goal {
    Goal {
        missed,
        mean_mm,
        held_mm: None,
        false_touches,
        longest_ms: None,
        right: None,
    }
}

/// The mean error of place at the end of a press.
const fn held(mm: f64) -> Goal {
    Goal {
        held_mm: Some(mm),
        ..goal(None, None, None)
    }
}

/// So many presses have the right number of touches.
const fn right(share: f64) -> Goal {
    Goal {
        right: Some(share),
        ..goal(None, None, None)
    }
}

/// Every condition of the table, in its order.
#[must_use]
pub fn conditions() -> Vec<Condition> {
    let still = ROWS.iter().map(|(name, list, snr_db, hand, goal)| {
        (name, *list, *snr_db, Surroundings::Still, hand, goal)
    });
    let surrounded = SURROUNDED
        .iter()
        .map(|(name, surroundings, hand, goal)| (name, "", 60.0, *surroundings, hand, goal));
    still
        .chain(surrounded)
        .enumerate()
        .map(
            |(number, (name, list, snr_db, surroundings, hand, goal))| Condition {
                number,
                name,
                disturbances: list
                    .split(',')
                    .filter_map(|name| name.parse().ok())
                    .collect(),
                snr_db,
                hand: *hand,
                surroundings,
                goal: *goal,
            },
        )
        .collect()
}

/// A finger and an untouched pad under a user's own disturbances, with white noise beside them.
#[must_use]
pub fn own_conditions(disturbances: &[Disturbance], snr_db: f64) -> Vec<Condition> {
    [
        (0, "a finger", Hand::Finger),
        (1, "untouched", Hand::Untouched),
    ]
    .map(|(number, name, hand)| Condition {
        number,
        name,
        disturbances: disturbances.to_vec(),
        snr_db,
        hand,
        surroundings: Surroundings::Still,
        goal: Goal::default(),
    })
    .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_in_the_table_is_a_disturbance() {
        for ((name, list, ..), condition) in ROWS.iter().zip(conditions()) {
            let named = list.split(',').filter(|name| !name.is_empty()).count();
            assert_eq!(condition.disturbances.len(), named, "{name}");
        }
    }
}
