//! Contacts moved to where presses at known places have shown them to be.
//!
//! What a pad's model gets wrong is a smooth displacement: part of it depends on the place alone (an outline, electrodes
//! or a lattice that differ from the drawing), part shows only in the voltages. Both are components of one Gaussian process
//! over the presses of a calibration, so a lone contact takes the sum, several contacts the place's part each, and far from
//! every press both fade to nothing: the model's own place stands. Force is bent so that the user's usual press
//! is the middle of the range.
//!
//! Invariant: sums run in the order of the presses and functions come from `libm`, so the same contacts are moved alike on
//! every machine.

use serde::{Deserialize, Serialize};

use crate::types::{Contact, PointMm};

/// Lanes of the distance's sum: a fixed order that the compiler can still vectorise.
const LANES: usize = 8;
/// Most presses that are kept: a frame costs a pass over them all.
pub const MOST_CORRECTION_PRESSES: usize = 400;

/// What a correction is made of, as it is saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrectionData {
    /// Width and height of the pad, mm: no contact is moved beyond.
    pub size_mm: [f64; 2],
    /// A factor a channel on the signed root of its relative change; zero for a channel that tells nothing.
    pub gains: Vec<f32>,
    /// Where the model saw each press, mm.
    pub places_mm: Vec<PointMm>,
    /// Each press' voltages, as [`signature`] gives them: presses by channels, press after press.
    pub signatures: Vec<f32>,
    /// Each press' weight, mm.
    pub weights_mm: Vec<[f64; 2]>,
    /// Length scale over the pad, mm, and prior variance of the place's part.
    pub place: Component,
    /// Length scale over signatures and prior variance of the voltages' part.
    pub voltages: Component,
    /// Power to which force is taken.
    pub force_power: f64,
}

/// One part of the process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Component {
    /// How far a press tells about.
    pub length: f64,
    /// Its share of the prior variance.
    pub variance: f64,
}

/// A correction that can be applied.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    data: CorrectionData,
    signature: Vec<f32>,
}

/// Why data is no correction.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CorrectionError {
    /// Lists of different lengths.
    #[error("the correction's lists differ in length: the file is damaged; calibrate again")]
    Lengths,
    /// A number that cannot be.
    #[error(
        "the correction holds a number out of range ({0}): the file is damaged; calibrate again"
    )]
    Number(&'static str),
}

impl Correction {
    /// Checks data.
    ///
    /// # Errors
    /// Lists whose lengths do not fit; numbers that are not finite or out of range.
    pub fn new(data: CorrectionData) -> Result<Self, CorrectionError> {
        let (presses, channels) = (data.places_mm.len(), data.gains.len());
        if data.weights_mm.len() != presses
            || data.signatures.len() != presses * channels
            || channels == 0
            || presses > MOST_CORRECTION_PRESSES
        {
            return Err(CorrectionError::Lengths);
        }
        let pairs = |list: &[[f64; 2]]| list.iter().flatten().all(|value| value.is_finite());
        let singles = |list: &[f32]| list.iter().all(|value| value.is_finite());
        let component = |c: Component| {
            c.length.is_finite() && c.length > 0.0 && (0.0..1e9).contains(&c.variance)
        };
        for (sound, what) in [
            (
                data.size_mm
                    .iter()
                    .all(|side| side.is_finite() && *side > 0.0),
                "size_mm",
            ),
            (singles(&data.gains), "gains"),
            (pairs(&data.places_mm), "places_mm"),
            (singles(&data.signatures), "signatures"),
            (pairs(&data.weights_mm), "weights_mm"),
            (component(data.place), "place"),
            (component(data.voltages), "voltages"),
            ((0.01..=100.0).contains(&data.force_power), "force_power"),
        ] {
            if !sound {
                return Err(CorrectionError::Number(what));
            }
        }
        Ok(Self {
            signature: vec![0.0; channels],
            data,
        })
    }

    /// Values a frame must have.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.data.gains.len()
    }

    /// What it is made of.
    #[must_use]
    pub fn data(&self) -> &CorrectionData {
        &self.data
    }

    /// Moves the contacts of a frame whose relative changes (v - v0) / v0 are given.
    ///
    /// # Panics
    /// If there are other channels than were learned from.
    pub fn apply(&mut self, changes: &[f32], contacts: &mut [Contact]) {
        assert_eq!(changes.len(), self.channels());
        if let [lone] = contacts {
            signature(changes, &self.data.gains, &mut self.signature);
            lone.centre_mm = self.moved(lone.centre_mm, true);
        } else {
            for contact in contacts.iter_mut() {
                contact.centre_mm = self.moved(contact.centre_mm, false);
            }
        }
        for contact in contacts {
            contact.force = libm::pow(contact.force.clamp(0.0, 1.0), self.data.force_power);
        }
    }

    /// Where a place moves to; by the voltages' part too, if these are one press' alone.
    fn moved(&self, place_mm: PointMm, by_voltages: bool) -> PointMm {
        let data = &self.data;
        let mut moved = place_mm;
        let presses = data.places_mm.iter().zip(&data.weights_mm);
        for ((press, weight), seen) in presses.zip(data.signatures.chunks_exact(self.channels())) {
            let mut likeness =
                data.place.variance * place_kernel(place_mm, *press, data.place.length);
            if by_voltages && data.voltages.variance > 0.0 {
                likeness += data.voltages.variance
                    * signature_kernel(&self.signature, seen, data.voltages.length);
            }
            moved[0] += likeness * weight[0];
            moved[1] += likeness * weight[1];
        }
        [0, 1].map(|axis| {
            // A place that is no number (voltages beyond all bounds) is left where the model put it.
            let value = if moved[axis].is_finite() {
                moved[axis]
            } else {
                place_mm[axis]
            };
            value.clamp(0.0, data.size_mm[axis])
        })
    }
}

/// Relative changes as presses are compared by: signed roots, each channel by its gain.
pub fn signature(changes: &[f32], gains: &[f32], out: &mut [f32]) {
    for ((out, change), gain) in out.iter_mut().zip(changes).zip(gains) {
        *out = libm::copysignf(libm::sqrtf(change.abs()), *change) * gain;
    }
}

/// How much presses at two places have in common, 0 to 1.
#[must_use]
pub fn place_kernel(a: PointMm, b: PointMm, length_mm: f64) -> f64 {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    matern(dx * dx + dy * dy, length_mm)
}

/// How much presses with two signatures have in common, 0 to 1.
#[must_use]
pub fn signature_kernel(a: &[f32], b: &[f32], length: f64) -> f64 {
    let mut lanes = [0.0_f32; LANES];
    let (whole_a, rest_a) = a.as_chunks::<LANES>();
    let (whole_b, rest_b) = b.as_chunks::<LANES>();
    for (a, b) in whole_a.iter().zip(whole_b) {
        for (sum, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            let gap = a - b;
            *sum += gap * gap;
        }
    }
    let mut sum = 0.0_f64;
    for lane in lanes {
        sum += f64::from(lane);
    }
    for (a, b) in rest_a.iter().zip(rest_b) {
        let gap = f64::from(a - b);
        sum += gap * gap;
    }
    matern(sum, length)
}

/// Matern 5/2 of a squared distance.
fn matern(distance2: f64, length: f64) -> f64 {
    let s = libm::sqrt(5.0 * distance2) / length;
    (1.0 + s + s * s / 3.0) * libm::exp(-s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data() -> CorrectionData {
        CorrectionData {
            size_mm: [100.0, 80.0],
            gains: vec![1.0; 10],
            places_mm: vec![[50.0, 40.0], [20.0, 20.0]],
            signatures: [vec![0.1_f32; 10], vec![-0.3; 10]].concat(),
            weights_mm: vec![[4.0, -2.0], [-6.0, 1.0]],
            place: Component {
                length: 5.0,
                variance: 0.5,
            },
            voltages: Component {
                length: 0.2,
                variance: 0.5,
            },
            force_power: 0.5,
        }
    }

    fn contact(centre_mm: PointMm) -> Contact {
        Contact {
            centre_mm,
            area_mm2: 100.0,
            force: 0.25,
            confidence: 1.0,
        }
    }

    #[test]
    fn a_lone_contact_moves_by_place_and_voltages_several_by_their_places() {
        let mut correction = Correction::new(data()).expect("sound");
        let like_first = [0.01_f32; 10];
        let mut lone = [contact([50.0, 40.0])];
        correction.apply(&like_first, &mut lone);
        let [x, y] = lone[0].centre_mm;
        assert!(
            (x - 54.0).abs() < 0.05 && (y - 38.0).abs() < 0.05,
            "{x} {y}"
        );
        let mut two = [contact([50.0, 40.0]), contact([20.0, 20.0])];
        correction.apply(&like_first, &mut two);
        let [x, y] = two[0].centre_mm;
        assert!(
            (x - 52.0).abs() < 0.05 && (y - 39.0).abs() < 0.05,
            "{x} {y}"
        );
        assert!((two[1].centre_mm[0] - 17.0).abs() < 0.05);
    }

    #[test]
    fn far_from_every_press_the_model_stands() {
        let mut correction = Correction::new(data()).expect("sound");
        let mut lone = [contact([95.0, 75.0])];
        correction.apply(&[0.9; 10], &mut lone);
        assert!((lone[0].centre_mm[0] - 95.0).abs() < 0.01);
        assert!((lone[0].centre_mm[1] - 75.0).abs() < 0.01);
    }

    #[test]
    fn force_keeps_its_order_and_its_ends() {
        let mut correction = Correction::new(data()).expect("sound");
        let mut contacts: Vec<Contact> = (0..=10)
            .map(|tenth| Contact {
                force: f64::from(tenth) / 10.0,
                ..contact([90.0, 10.0])
            })
            .collect();
        correction.apply(&[0.0; 10], &mut contacts);
        assert_eq!(contacts[0].force, 0.0);
        assert_eq!(contacts[10].force, 1.0);
        assert!(contacts.is_sorted_by(|a, b| a.force < b.force));
    }

    #[test]
    fn no_contact_leaves_the_pad_whatever_the_voltages() {
        let mut correction = Correction::new(data()).expect("sound");
        for change in [f32::NAN, f32::INFINITY, -1e30, 0.01] {
            let mut lone = [contact([50.0, 79.9])];
            correction.apply(&[change; 10], &mut lone);
            let [x, y] = lone[0].centre_mm;
            assert!((0.0..=100.0).contains(&x) && (0.0..=80.0).contains(&y));
        }
    }

    #[test]
    fn damaged_data_is_refused() {
        type Damage = fn(&mut CorrectionData);
        let damages: [Damage; 5] = [
            |d| d.weights_mm.truncate(1),
            |d| d.signatures.truncate(19),
            |d| d.gains[0] = f32::NAN,
            |d| d.place.length = 0.0,
            |d| d.force_power = -1.0,
        ];
        for damage in damages {
            let mut damaged = data();
            damage(&mut damaged);
            assert!(Correction::new(damaged).is_err());
        }
    }
}
