//! The fingers and parts of gamepads that count, where they are and which places they are for; and what several of them make together.

use super::accept::Passed;
use super::layout::Covered;
use crate::types::{Nanos, PointMm, TouchId};

/// As many as are watched.
const MOST_FINGERS: usize = 32;

/// A finger that counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finger {
    pub id: TouchId,
    pub is_part: bool,
    pub down_ns: Nanos,
    pub first_mm: PointMm,
    pub at_mm: PointMm,
    pub force: f64,
    pub covered: Covered,
}

/// All of them, in the order in which they went down.
#[derive(Clone, Debug)]
pub(super) struct Fingers(Vec<Finger>);

impl Fingers {
    pub(super) fn new() -> Self {
        Self(Vec::with_capacity(MOST_FINGERS))
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    pub(super) fn add(&mut self, t_ns: Nanos, passed: &Passed, covered: Covered) -> Finger {
        let finger = Finger {
            id: passed.id,
            is_part: passed.part.is_some(),
            down_ns: t_ns,
            first_mm: passed.at_mm,
            at_mm: passed.at_mm,
            force: passed.force,
            covered,
        };
        self.0.push(finger);
        finger
    }

    pub(super) fn get_mut(&mut self, id: TouchId) -> Option<&mut Finger> {
        self.0.iter_mut().find(|finger| finger.id == id)
    }

    pub(super) fn remove(&mut self, id: TouchId) {
        self.0.retain(|finger| finger.id != id);
    }

    /// Those in any of some regions; all on the pad where none is named.
    fn among<'a>(&'a self, regions: &'a [usize]) -> impl Iterator<Item = &'a Finger> {
        self.0.iter().filter(move |finger| {
            (regions.is_empty() && !finger.is_part)
                || regions
                    .iter()
                    .any(|region| finger.covered.contains(*region))
        })
    }

    /// How many are in any of some regions.
    pub(super) fn count(&self, regions: &[usize]) -> usize {
        self.among(regions).count()
    }

    /// The middle of those in any of some regions.
    pub(super) fn middle(&self, regions: &[usize]) -> PointMm {
        let count = self.count(regions).max(1) as f64;
        let sum = self.among(regions).fold([0.0; 2], |sum, finger| {
            [sum[0] + finger.at_mm[0], sum[1] + finger.at_mm[1]]
        });
        sum.map(|sum| sum / count)
    }

    /// Whether each of some places is touched; and between the first and the last of these touches, how long.
    pub(super) fn chord(&self, places: &[usize]) -> Option<Nanos> {
        let (mut first, mut last) = (Nanos::MAX, 0);
        for place in places {
            let finger = self
                .0
                .iter()
                .find(|finger| finger.covered.contains(*place))?;
            first = first.min(finger.down_ns);
            last = last.max(finger.down_ns);
        }
        Some(last.saturating_sub(first))
    }
}
