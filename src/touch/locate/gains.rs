//! How much of a touch gains of the source explain. Where it is nearly all, as on a pad with few readings of each drive or with opposite drives,
//! a frame of gains cannot be told from a touch.

use super::metric::energy;
use super::model::LocatorModel;
use crate::eit::response::Response;

/// Places along each side of the pad.
const PLACES: usize = 11;
/// Where gains explain more than this share of a touch, a frame of gains may be a touch. On pads with sixteen electrodes, adjacent drives and
/// adjacent readings it is a half; with opposite drives, four fifths.
const MOST_SHARE: f64 = 0.6;

impl LocatorModel {
    /// Whether no touch, at any place and of any size, looks like gains of the drives; `drives` is the drive of each channel.
    #[must_use]
    pub(in crate::touch) fn are_gains_distinct(&self, drives: &[u16]) -> bool {
        let [width_mm, height_mm] = self.bounds.size_mm;
        let [least, most] = self.bounds.log_radius;
        let along = |place: usize| place as f64 / (PLACES - 1) as f64;
        let mut response = Response::default();
        let mut changes = vec![0.0; self.table.channels()];
        (0..PLACES * PLACES).all(|place| {
            let centre_mm = [
                along(place % PLACES) * width_mm,
                along(place / PLACES) * height_mm,
            ];
            let mut touch = self.bounds.typical(centre_mm);
            [least, self.bounds.typical_log_radius, most]
                .into_iter()
                .all(|log_radius| {
                    touch.log_radius = log_radius;
                    self.table.respond(&touch, &mut response);
                    self.table.expand(&response.value, &mut changes);
                    explained_by_gains(&changes, drives) <= MOST_SHARE * energy(&changes)
                })
        })
    }
}

/// The sum of squares of the changes that one gain of each drive explains.
fn explained_by_gains(changes: &[f32], drives: &[u16]) -> f64 {
    let count = drives.iter().max().map_or(0, |last| usize::from(*last) + 1);
    let mut sums = vec![(0.0, 0.0); count];
    for (change, drive) in changes.iter().zip(drives) {
        let (sum, readings) = &mut sums[usize::from(*drive)];
        *sum += f64::from(*change);
        *readings += 1.0;
    }
    let used = sums.iter().filter(|(_, readings)| *readings > 0.0);
    used.map(|(sum, readings)| sum * sum / readings).sum()
}
