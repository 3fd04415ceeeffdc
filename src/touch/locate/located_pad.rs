//! What locating touches needs to know of a pad beside its response table.

use std::sync::Arc;

use crate::pad::{LearnedMaps, Outline, Pad, TouchSign};

/// Model error of a pad as drawn, as a share of a frame's amplitude: pads differ from their drawing.
const DRAWN_ERROR: f64 = 0.04;
/// The same of a pad as found: its table is derived to first order, from readings that do not tell everything.
pub(super) const FOUND_ERROR: f64 = 0.015;
/// Least distance between two touches, mm: a finger's width. What looks closer on a pad as drawn is one wide or oval finger.
const DRAWN_APART_MM: f64 = 12.5;
/// Least distance on a pad as found: closer, even exact responses hardly differ.
const FOUND_APART_MM: f64 = 8.0;
/// Most touches: the fingers of two hands.
const MOST_TOUCHES: usize = 10;
/// On learned maps more touches cannot be told apart, and an odd frame would be explained by a crowd of them.
const MOST_LEARNED_TOUCHES: usize = 4;

/// A pad as the locator knows it.
#[derive(Clone, Debug)]
pub(in crate::touch) struct LocatedPad {
    pub(super) outline: Outline,
    /// Sign of the touches that are expected.
    pub(super) sign: TouchSign,
    /// Maps of a pad that was learned from presses.
    pub(super) learned: Option<Arc<LearnedMaps>>,
    /// Model error as a share of the frame's amplitude.
    pub(super) error_share: f64,
    /// Least distance between two touches, mm.
    pub(super) least_apart_mm: f64,
    /// How many touches may be down at once.
    pub(super) most_touches: usize,
}

impl From<&Pad> for LocatedPad {
    fn from(pad: &Pad) -> Self {
        let (error_share, least_apart_mm) = match &pad.learned {
            Some(maps) => (maps.error_share(), DRAWN_APART_MM),
            None if pad.deviations.is_none() => (DRAWN_ERROR, DRAWN_APART_MM),
            None => (FOUND_ERROR, FOUND_APART_MM),
        };
        Self {
            outline: pad.outline,
            sign: pad.touch_sign,
            learned: pad.learned.clone(),
            error_share,
            least_apart_mm,
            most_touches: match pad.learned {
                Some(_) => MOST_LEARNED_TOUCHES,
                None => MOST_TOUCHES,
            },
        }
    }
}
