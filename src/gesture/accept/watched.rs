//! A touch that is watched, whether it counts or not.

use crate::types::{Nanos, Phase, PointMm, TouchId};

/// A finger that counts, at one moment.
#[derive(Clone, Copy, Debug)]
pub(in crate::gesture) struct AcceptedTouch {
    pub phase: Phase,
    pub id: TouchId,
    /// The place of a part of a gamepad; none for a finger.
    pub part: Option<usize>,
    /// Place on the pad, mm. Of a part of a gamepad, whose travel has no length: share of its travel, -1 to 1.
    pub at_mm: PointMm,
    /// 0..1 of the person's range.
    pub force: f64,
    /// Of a disc of the same area.
    pub radius_mm: f64,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Watched {
    /// Its id at the source; a finger that returned after a tremor has a new one there.
    pub source: TouchId,
    /// Its id as an accepted touch.
    pub finger: TouchId,
    /// A region, or a part of a gamepad.
    pub place: Option<usize>,
    pub is_part: bool,
    pub since_ns: Nanos,
    /// Where it went down.
    pub first_mm: PointMm,
    /// Where it counts.
    pub at_mm: PointMm,
    pub force: f64,
    pub radius_mm: f64,
    /// When it returned last, and when it had lifted before.
    pub returned: Option<(Nanos, Nanos)>,
    pub state: WatchedState,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WatchedState {
    /// Counts from this time on, if it is still down.
    Waiting { due_ns: Nanos },
    /// Lifted while it waited; goes on waiting if it returns by `until_ns`.
    Away { due_ns: Nanos, until_ns: Nanos },
    /// Counts when it lifts.
    UntilLift,
    /// Counts.
    Accepted,
    /// Lifted, unless it returns by this time.
    Lifting { due_ns: Nanos },
    /// Ignored until it lifts.
    Ignored,
    /// A resting hand or arm (large), or a contact that meets one.
    Resting { is_large: bool },
    /// A hand or arm rested here: its image breaks up and joins again from frame to frame.
    JustRested { until_ns: Nanos },
}

impl WatchedState {
    pub(super) fn next_due(self) -> Option<Nanos> {
        match self {
            Self::Waiting { due_ns }
            | Self::Away {
                until_ns: due_ns, ..
            }
            | Self::Lifting { due_ns }
            | Self::JustRested { until_ns: due_ns } => Some(due_ns),
            Self::UntilLift | Self::Accepted | Self::Ignored | Self::Resting { .. } => None,
        }
    }
}

impl Watched {
    pub(super) fn accepted(&self, phase: Phase) -> AcceptedTouch {
        AcceptedTouch {
            phase,
            id: self.finger,
            part: self.place.filter(|_| self.is_part),
            at_mm: self.at_mm,
            force: self.force,
            radius_mm: self.radius_mm,
        }
    }
}

/// A place that follows another one on a slack string: smaller moves are ignored.
pub(super) fn follow_with_slack(at_mm: PointMm, to_mm: PointMm, slack_mm: f64) -> PointMm {
    let distance = distance_mm(at_mm, to_mm);
    if slack_mm == 0.0 {
        return to_mm;
    }
    if distance < slack_mm {
        return at_mm;
    }
    let share = (distance - slack_mm) / distance;
    [0, 1].map(|i| at_mm[i] + share * (to_mm[i] - at_mm[i]))
}

pub(super) fn radius_mm(area_mm2: f64) -> f64 {
    libm::sqrt(area_mm2.max(0.0) / core::f64::consts::PI)
}

pub(in crate::gesture) fn distance_mm(a: PointMm, b: PointMm) -> f64 {
    let [dx, dy] = [a[0] - b[0], a[1] - b[1]];
    libm::sqrt(dx * dx + dy * dy)
}
