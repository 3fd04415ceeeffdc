//! A board that was plugged in again, turned or mirrored: it numbers the electrodes from another place.
//!
//! The untouched readings show it: no pad is as symmetric as its drawing, so only one numbering makes them agree with the
//! reference. From then on frames are brought into the pad's order before anything else sees them, so the reference, the
//! noise and the places of touches stay valid. Nearly all readings must agree, not just most: a finger that moves from the place
//! under which the reference was taken to about the mirrored one changes few of them.
//!
//! Invariant: another numbering is taken only if it explains several frames in a row far better than the present one.

use super::Detector;
use crate::eit::Reference;
use crate::pad::{Numbering, Protocol, Renumbered};
use crate::types::{Frame, Touch};

/// A frame is compared if its median change exceeds this many deviations of the noise.
const LEAST_CHANGE: f64 = 4.0;
/// Another numbering must leave less than this share of what the present one leaves, ...
const BETTER: f32 = 0.25;
/// ... and no more than this many deviations of the noise: a turned board is recognised while no finger is down, ...
const LEFT: f32 = 2.4;
/// ... for this many frames in a row.
const FRAMES: usize = 3;
/// What a numbering leaves is the deviation that this share of the readings stays below: of noise alone 1.96.
const NEARLY_ALL: f64 = 0.95;

/// The numberings that a board may have, and the present one.
#[derive(Clone, Debug, Default)]
pub(super) struct BoardNumbering {
    orders: Vec<(Numbering, Renumbered)>,
    /// Index of the present one. The first is that of the reference.
    present: usize,
    /// The numbering that explained the last frames, and how many.
    suspect: Option<(usize, usize)>,
    /// How often the board changed its numbering.
    changes: u64,
    /// The frame in the pad's order.
    placed: Frame,
    candidate: Vec<f32>,
    ratios: Vec<f32>,
}

impl BoardNumbering {
    /// All numberings with which a board can measure a protocol.
    pub(super) fn new(protocol: &Protocol) -> Self {
        let orders = Numbering::all(protocol.electrodes)
            .filter_map(|numbering| Some((numbering, Renumbered::new(protocol, numbering)?)))
            .collect();
        Self {
            orders,
            ..Self::default()
        }
    }

    /// Takes the buffer with the frame in the pad's order, unless the frame is in that order already.
    pub(super) fn place(&mut self, frame: &Frame) -> Option<Frame> {
        if self.present == 0 {
            return None;
        }
        let mut placed = std::mem::take(&mut self.placed);
        placed.t_ns = frame.t_ns;
        self.orders[self.present]
            .1
            .apply_into(&frame.volts, &mut placed.volts);
        Some(placed)
    }

    /// Returns the buffer.
    pub(super) fn give_back(&mut self, placed: Frame) {
        self.placed = placed;
    }

    /// The numbering that agrees best with the reference, if it leaves far less than the present one.
    fn better(&mut self, volts: &[f32], reference: &Reference) -> Option<usize> {
        let mut misfit_of = |order: &Renumbered| {
            order.apply_into(volts, &mut self.candidate);
            misfit(&self.candidate, reference, &mut self.ratios)
        };
        let present = misfit_of(&self.orders[self.present].1)?;
        let others = self.orders.iter().enumerate();
        let misfits = others.filter_map(|(index, (_, order))| Some((index, misfit_of(order)?)));
        let (index, least) = misfits.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        (least < LEFT.min(BETTER * present)).then_some(index)
    }
}

/// Deviation of nearly all readings from the reference, after their common gain, in deviations of their noise. `None` if most
/// are not numbers.
fn misfit(volts: &[f32], reference: &Reference, ratios: &mut Vec<f32>) -> Option<f32> {
    ratios.clear();
    let used = || (0..volts.len()).filter(|channel| !reference.is_muted(*channel));
    let ratio = |channel: usize| volts[channel] / reference.volts()[channel] as f32;
    ratios.extend(used().map(ratio));
    let gain = quantile(ratios, 0.5)?;
    ratios.clear();
    ratios.extend(used().map(|channel| {
        let [noise, doubt] = reference.variances(channel);
        (ratio(channel) / gain - 1.0).abs() / ((noise + doubt) as f32).sqrt()
    }));
    quantile(ratios, NEARLY_ALL).filter(|misfit| misfit.is_finite())
}

/// The value that a share of the values stays below; reorders them.
fn quantile(values: &mut [f32], share: f64) -> Option<f32> {
    let index = (values.len() as f64 * share) as usize;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(index, f32::total_cmp).1)
}

impl Detector {
    /// Whether the frame must be skipped because the board seems to number its electrodes from another place. `raw` is the
    /// frame as the board sent it. After a few such frames that numbering is the present one.
    pub(super) fn is_renumbered(&mut self, raw: &Frame, changed: &mut Vec<Touch>) -> bool {
        let is_possible =
            self.knows_both_signs() && self.tracker.down().is_empty() && !self.is_between;
        if !is_possible || !self.is_changed_as_a_whole() {
            self.numbering.suspect = None;
            return false;
        }
        let Some(index) = self.numbering.better(&raw.volts, &self.reference) else {
            self.numbering.suspect = None;
            return false;
        };
        let frames = match self.numbering.suspect {
            Some((suspect, frames)) if suspect == index => frames + 1,
            _ => 1,
        };
        self.numbering.suspect = Some((index, frames));
        if frames == FRAMES {
            self.lift_all(changed);
            self.numbering.suspect = None;
            self.numbering.present = index;
            self.numbering.changes += 1;
        }
        true
    }

    /// Whether the board sends readings in the order of the pad.
    pub(in crate::touch) fn is_in_own_order(&self) -> bool {
        self.numbering.present == 0
    }

    /// Whether half of the readings changed by more than noise.
    fn is_changed_as_a_whole(&mut self) -> bool {
        let ratios = &mut self.numbering.ratios;
        ratios.clear();
        let used = (0..self.changes.len()).filter(|channel| !self.reference.is_muted(*channel));
        ratios.extend(used.map(|channel| self.changes[channel].abs()));
        let limit = LEAST_CHANGE * self.reference.change_noise();
        quantile(ratios, 0.5).is_some_and(|median| f64::from(median) > limit)
    }

    /// The place of the board's electrode 0 and its direction, relative to those of the start, and how often they changed.
    #[must_use]
    pub fn board_numbering(&self) -> (Numbering, u64) {
        let numbering = &self.numbering;
        let present = numbering.orders.get(numbering.present);
        (
            present.map_or_else(Numbering::default, |(numbering, _)| *numbering),
            numbering.changes,
        )
    }
}
