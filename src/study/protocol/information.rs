//! What readings tell about a finger: Fisher information of its place, radius and rise.

use nalgebra::{Matrix4, Vector4};
use serde::{Deserialize, Serialize};

use crate::study::{Slopes, mean_distance_mm};

/// Standard deviations of radius (mm) and rise of any finger: those of the fingers drawn for `gelpad accuracy`.
const FINGER_SD: [f64; 2] = [1.15, 0.43];
/// Standard deviation of a uniform distribution, as a share of its length: 1 / sqrt 12.
const UNIFORM_SD: f64 = 0.288_675_134_594_812_9;

/// What every reading tells about one finger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PressInformation {
    /// For each channel its derivatives by x, y (per mm), radius (per mm) and rise, in deviations of its noise.
    slopes: Vec<[f64; 4]>,
    /// The change of each channel by the finger, in deviations of its noise.
    changes: Vec<f64>,
}

/// What is known about a finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knowledge {
    /// Fisher information of x, y, radius and rise.
    information: Matrix4<f64>,
    /// Sum of the squared changes in deviations of their noise.
    pub(super) chi2: f64,
}

impl PressInformation {
    /// From the readings (V/A) with and without the finger, and noise proportional to each reading.
    pub(super) fn new(rest: &[f64], volts: &[f64], slopes: &Slopes, snr_db: f64) -> Self {
        let noise = libm::pow(10.0, -snr_db / 20.0);
        let deviations: Vec<f64> = volts.iter().map(|volt| noise * volt.abs()).collect();
        Self {
            slopes: slopes.of_first_press(&deviations),
            changes: rest
                .iter()
                .zip(volts)
                .zip(&deviations)
                .map(|((rest, volt), deviation)| (volt - rest) / deviation)
                .collect(),
        }
    }

    /// Number of channels.
    pub(super) fn channels(&self) -> usize {
        self.slopes.len()
    }

    /// What some channels tell.
    pub(super) fn of_channels(&self, channels: impl IntoIterator<Item = usize>) -> Knowledge {
        let mut knowledge = Knowledge {
            information: Matrix4::zeros(),
            chi2: 0.0,
        };
        for channel in channels {
            let slope = Vector4::from(self.slopes[channel]);
            knowledge.information += slope * slope.transpose();
            knowledge.chi2 += self.changes[channel] * self.changes[channel];
        }
        knowledge
    }
}

impl Knowledge {
    /// What is known about a finger that may be anywhere on a pad of this size, mm.
    pub(super) fn of_any_finger(size_mm: [f64; 2]) -> Self {
        let [width, height] = size_mm.map(|length| UNIFORM_SD * length);
        let [radius, rise] = FINGER_SD;
        let diagonal = [width, height, radius, rise].map(|sd| 1.0 / (sd * sd));
        Self {
            information: Matrix4::from_diagonal(&Vector4::from(diagonal)),
            chi2: 0.0,
        }
    }

    pub(super) fn and(&self, other: &Self) -> Self {
        Self {
            information: self.information + other.information,
            chi2: self.chi2 + other.chi2,
        }
    }

    pub(super) fn without(&self, other: &Self) -> Self {
        Self {
            information: self.information - other.information,
            chi2: self.chi2 - other.chi2,
        }
    }

    /// Least variances of x and y and their covariance, mm2; `None` if they are not determined.
    fn place_mm2(&self) -> Option<[f64; 3]> {
        let covariance = self.information.cholesky()?.inverse();
        Some([covariance[(0, 0)], covariance[(1, 1)], covariance[(0, 1)]])
    }

    /// Least root mean square error of place, mm; infinite if it is not determined.
    pub(super) fn rms_mm(&self) -> f64 {
        self.place_mm2()
            .map_or(f64::INFINITY, |[xx, yy, _]| libm::sqrt(xx + yy))
    }

    /// Least mean error of place, mm; infinite if it is not determined.
    pub(super) fn mean_mm(&self) -> f64 {
        self.place_mm2().map_or(f64::INFINITY, mean_distance_mm)
    }
}
