//! The fingers and parts of gamepads that count: where they are, and which places they are for.

use super::accept::{AcceptedTouch, distance_mm};
use super::layout::Covered;
use crate::types::{Nanos, PointMm, TouchId};

/// Fingers for which there is room without an allocation.
const MAX_FINGERS: usize = 32;

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

/// A touch at one moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct TouchSample {
    pub id: TouchId,
    /// The region or part of a gamepad that the binding is played in; none for the whole pad.
    pub place: Option<usize>,
    pub at_mm: PointMm,
    /// Distance from where the touch went down.
    pub moved_mm: f64,
    /// 0..1.
    pub force: f64,
}

impl Finger {
    /// The finger as the bindings of a place see it.
    pub(super) fn sample(&self, place: Option<usize>) -> TouchSample {
        TouchSample {
            id: self.id,
            place,
            at_mm: self.at_mm,
            moved_mm: distance_mm(self.first_mm, self.at_mm),
            force: self.force,
        }
    }
}

/// All fingers, in the order in which they went down.
#[derive(Clone, Debug)]
pub(super) struct Fingers(Vec<Finger>);

impl Fingers {
    pub(super) fn new() -> Self {
        Self(Vec::with_capacity(MAX_FINGERS))
    }

    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    pub(super) fn add(&mut self, t_ns: Nanos, touch: &AcceptedTouch, covered: Covered) -> Finger {
        let finger = Finger {
            id: touch.id,
            is_part: touch.part.is_some(),
            down_ns: t_ns,
            first_mm: touch.at_mm,
            at_mm: touch.at_mm,
            force: touch.force,
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

    /// Fingers in any of some regions; without regions, all on the pad.
    fn within<'a>(&'a self, regions: &'a [usize]) -> impl Iterator<Item = &'a Finger> {
        self.0.iter().filter(move |finger| {
            let mut regions_in = regions.iter();
            (regions.is_empty() && !finger.is_part)
                || regions_in.any(|region| finger.covered.contains(*region))
        })
    }

    /// Number of fingers in any of some regions.
    pub(super) fn count(&self, regions: &[usize]) -> usize {
        self.within(regions).count()
    }

    /// The fingers in some regions as one touch at their centroid.
    pub(super) fn group_sample(&self, id: TouchId, regions: &[usize]) -> TouchSample {
        let count = self.count(regions).max(1) as f64;
        let sum = self.within(regions).fold([0.0; 2], |sum, finger| {
            [sum[0] + finger.at_mm[0], sum[1] + finger.at_mm[1]]
        });
        TouchSample {
            id,
            place: None,
            at_mm: sum.map(|sum| sum / count),
            moved_mm: 0.0,
            force: 0.0,
        }
    }

    /// The time between the first and the last touch of some places; none unless each is touched.
    pub(super) fn spread(&self, places: &[usize]) -> Option<Nanos> {
        let (mut first, mut last) = (Nanos::MAX, 0);
        for place in places {
            let mut fingers = self.0.iter();
            let finger = fingers.find(|finger| finger.covered.contains(*place))?;
            first = first.min(finger.down_ns);
            last = last.max(finger.down_ns);
        }
        Some(last.saturating_sub(first))
    }
}
