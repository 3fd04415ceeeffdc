//! Corrects the places of contacts by a calibration.
//!
//! A pad's model is off by a smooth displacement. One part depends on the place alone (an outline, electrodes or a lattice
//! that differ from the drawing), the other shows only in the voltages. Both are components of one Gaussian process over the
//! presses of a calibration. A lone contact is moved by their sum, several contacts each by the place component; far from
//! every press both vanish. Force is raised to a power that maps the user's median press to the middle of the range.
//!
//! Invariant: sums run in the order of the presses and functions come from `libm`, so the result is the same on every machine.

use serde::{Deserialize, Serialize};

use crate::types::{Contact, PointMm};

/// Lanes of the sum of a distance: a fixed order that the compiler can vectorise.
const LANES: usize = 8;
/// Most presses of a correction; each frame takes a pass over all of them.
pub const MOST_CORRECTION_PRESSES: usize = 400;

/// The data of a correction, as it is saved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CorrectionData {
    /// Width and height of the pad, mm; contacts stay within.
    pub size_mm: [f64; 2],
    /// For each channel, a factor on the signed root of its relative change; 0 for a channel without information.
    pub gains: Vec<f32>,
    /// The model's place of each press, mm.
    pub places_mm: Vec<PointMm>,
    /// The [`signature`] of each press, one after the other.
    pub signatures: Vec<f32>,
    /// The weight of each press, mm.
    pub weights_mm: Vec<[f64; 2]>,
    /// The place component; its length is in mm.
    pub place: Component,
    /// The voltage component; its length is in units of signatures.
    pub voltages: Component,
    /// Exponent of the force.
    pub force_power: f64,
}

/// A component of the process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Component {
    /// Length scale.
    pub length: f64,
    /// Share of the prior variance.
    pub variance: f64,
}

/// A checked correction.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    data: CorrectionData,
    signature: Vec<f32>,
}

/// Why the data of a correction is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CorrectionError {
    /// Lists whose lengths do not match.
    #[error(
        "the lists of the correction do not match in length: the file is damaged; calibrate again"
    )]
    Lengths,
    /// A number out of range, and its field.
    #[error(
        "the correction contains a number out of range ({0}): the file is damaged; calibrate again"
    )]
    Number(&'static str),
}

impl Correction {
    /// Checks the data.
    ///
    /// # Errors
    /// Lists whose lengths do not match; numbers that are not finite or out of range.
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

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.data.gains.len()
    }

    /// The data.
    #[must_use]
    pub fn data(&self) -> &CorrectionData {
        &self.data
    }

    /// Corrects the contacts of a frame with relative changes (v - v0) / v0.
    ///
    /// # Panics
    /// If the number of channels is another.
    pub fn apply(&mut self, changes: &[f32], contacts: &mut [Contact]) {
        assert_eq!(changes.len(), self.channels());
        if let [lone] = contacts {
            signature(changes, &self.data.gains, &mut self.signature);
            lone.centre_mm = self.corrected_place(lone.centre_mm, true);
        } else {
            for contact in contacts.iter_mut() {
                contact.centre_mm = self.corrected_place(contact.centre_mm, false);
            }
        }
        for contact in contacts {
            contact.force = libm::pow(contact.force.clamp(0.0, 1.0), self.data.force_power);
        }
    }

    /// The corrected place; `by_voltages` adds the voltage component.
    fn corrected_place(&self, place_mm: PointMm, by_voltages: bool) -> PointMm {
        let data = &self.data;
        let mut moved = place_mm;
        let presses = data.places_mm.iter().zip(&data.weights_mm);
        for ((press, weight), signature) in
            presses.zip(data.signatures.chunks_exact(self.channels()))
        {
            let mut covariance =
                data.place.variance * place_kernel(place_mm, *press, data.place.length);
            if by_voltages && data.voltages.variance > 0.0 {
                covariance += data.voltages.variance
                    * signature_kernel(&self.signature, signature, data.voltages.length);
            }
            moved[0] += covariance * weight[0];
            moved[1] += covariance * weight[1];
        }
        [0, 1].map(|axis| {
            // Extreme voltages can give a place that is not finite: the model's place stays.
            let value = if moved[axis].is_finite() {
                moved[axis]
            } else {
                place_mm[axis]
            };
            value.clamp(0.0, data.size_mm[axis])
        })
    }
}

/// The signature of a frame: the signed root of each relative change, times the channel's gain.
pub fn signature(changes: &[f32], gains: &[f32], out: &mut [f32]) {
    for ((out, change), gain) in out.iter_mut().zip(changes).zip(gains) {
        *out = libm::copysignf(libm::sqrtf(change.abs()), *change) * gain;
    }
}

/// Covariance of two places, 0 to 1.
#[must_use]
pub fn place_kernel(a: PointMm, b: PointMm, length_mm: f64) -> f64 {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    matern(dx * dx + dy * dy, length_mm)
}

/// Covariance of two signatures, 0 to 1.
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

/// The Matern 5/2 kernel of a squared distance (Rasmussen and Williams 2006, eq. 4.17): 1 at distance 0.
#[must_use]
pub fn matern(distance2: f64, length: f64) -> f64 {
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
    fn a_lone_contact_moves_by_both_components_several_by_place() {
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
    fn far_from_every_press_nothing_moves() {
        let mut correction = Correction::new(data()).expect("sound");
        let mut lone = [contact([95.0, 75.0])];
        correction.apply(&[0.9; 10], &mut lone);
        assert!((lone[0].centre_mm[0] - 95.0).abs() < 0.01);
        assert!((lone[0].centre_mm[1] - 75.0).abs() < 0.01);
    }

    #[test]
    fn force_keeps_its_order_and_ends() {
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
    fn no_contact_leaves_the_pad_at_any_voltage() {
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
