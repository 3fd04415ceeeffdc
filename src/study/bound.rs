//! The Cramer-Rao bound of touches: the smallest errors of place and strength that any unbiased method can have with a
//! pad and its noise.
//!
//! A press has four unknowns: x, y, radius and rise. The Fisher information is F = D' W D, where D is the exact derivative
//! of the voltages in the touched state (adjoint fields times the derivative of the conductivity) and W holds one over the
//! variance of each reading. The inverse of F is the least covariance of an unbiased estimate (Kay 1993, theorem 3.2). The
//! untouched pad is taken as known; the little information in the size of the noise itself is ignored.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::{Press, StudyError, conductivity_factor};
use crate::eit::{ForwardModel, PRESS_UNKNOWNS, PressedPad};
use crate::pad::Pad;

/// Least errors of an unbiased estimate of one press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressBound {
    /// Variances along x and y and their covariance, mm2.
    place_mm2: [f64; 3],
    /// Standard deviation of the volume, as a share of it.
    pub volume_share: f64,
}

impl PressBound {
    /// Root mean square distance of the estimate from the truth, mm.
    #[must_use]
    pub fn rms_mm(&self) -> f64 {
        (self.place_mm2[0] + self.place_mm2[1]).sqrt()
    }

    /// Mean distance of the estimate from the truth for Gaussian errors with the bound's covariance, mm.
    #[must_use]
    pub fn mean_mm(&self) -> f64 {
        mean_distance_mm(self.place_mm2)
    }

    /// The bound with the noise multiplied by `times`.
    #[must_use]
    pub fn with_noise(&self, times: f64) -> Self {
        Self {
            place_mm2: self.place_mm2.map(|variance| variance * times * times),
            volume_share: self.volume_share * times,
        }
    }
}

/// Mean distance of Gaussian errors with these variances along x and y and this covariance, mm.
///
/// In polar form: the mean of a Rayleigh distribution times the mean radius of the ellipse over the circle.
pub(super) fn mean_distance_mm([xx, yy, xy]: [f64; 3]) -> f64 {
    const STEPS: usize = 64;
    let (middle, spread) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
    let mean_radius = (0..STEPS)
        .map(|step| {
            let angle = std::f64::consts::TAU * step as f64 / STEPS as f64;
            (middle + spread * angle.cos()).max(0.0).sqrt()
        })
        .sum::<f64>()
        / STEPS as f64;
    (std::f64::consts::PI / 2.0).sqrt() * mean_radius
}

/// Derivatives of the readings by place, radius and rise of every press.
#[derive(Clone, Debug)]
pub struct Slopes {
    presses: Vec<Press>,
    /// Channels by unknowns, V/A per unit of the unknown.
    derivative: Mat<f64>,
}

impl Slopes {
    /// Those of a pad in its touched state; valid for any noise.
    #[must_use]
    pub fn new(pressed: &PressedPad<'_>, pad: &Pad) -> Self {
        Self {
            presses: pressed.presses.to_vec(),
            derivative: pressed.slopes(&pad.protocol),
        }
    }

    /// The derivatives of each reading by the unknowns of the first press, in these deviations of the readings (V/A).
    pub(super) fn of_first_press(&self, deviations: &[f64]) -> Vec<[f64; PRESS_UNKNOWNS]> {
        let channels = deviations.iter().enumerate();
        channels
            .map(|(channel, deviation)| {
                std::array::from_fn(|unknown| self.derivative[(channel, unknown)] / deviation)
            })
            .collect()
    }

    /// The bound of each press with all presses unknown, for readings with these standard deviations (V/A); `None` if the
    /// readings do not determine the presses.
    ///
    /// # Panics
    /// If there is not one deviation for each channel.
    #[must_use]
    pub fn bounds(&self, deviations: &[f64]) -> Option<Vec<PressBound>> {
        let (channels, unknowns) = self.derivative.shape();
        assert_eq!(deviations.len(), channels);
        // Whitened: divided by the noise of each reading.
        let whitened = Mat::from_fn(channels, unknowns, |channel, unknown| {
            self.derivative[(channel, unknown)] / deviations[channel]
        });
        let information = whitened.transpose() * &whitened;
        let factor = information.llt(Side::Lower).ok()?;
        let covariance = factor.solve(Mat::<f64>::identity(unknowns, unknowns));
        let bounds = self.presses.iter().enumerate().map(|(index, press)| {
            let own = PRESS_UNKNOWNS * index;
            let entry = |a: usize, b: usize| covariance[(own + a, own + b)];
            let (radius, rise) = (press.radius_mm, press.rise);
            // The volume is proportional to rise x radius^2.
            let volume = entry(3, 3) / (rise * rise)
                + 4.0 * entry(2, 2) / (radius * radius)
                + 4.0 * entry(2, 3) / (rise * radius);
            PressBound {
                place_mm2: [entry(0, 0), entry(1, 1), entry(0, 1)],
                volume_share: volume.max(0.0).sqrt(),
            }
        });
        let bounds: Vec<PressBound> = bounds.collect();
        let sound = |bound: &PressBound| bound.rms_mm().is_finite() && bound.rms_mm() > 0.0;
        bounds.iter().all(sound).then_some(bounds)
    }
}

/// The bound of a press's place on a uniform pad, mm (root of the summed variances along x and y), for noise proportional to
/// each reading with this SNR (dB).
///
/// # Errors
/// A pad that cannot be solved, or a place that the voltages do not determine.
pub fn place_bound_mm(
    pad: &Pad,
    model: &ForwardModel,
    press: &Press,
    snr_db: f64,
) -> Result<f64, StudyError> {
    let presses = [*press];
    let background = vec![pad.background_s_per_m; model.mesh().triangles.len()];
    let conductivity = model.mesh().mean_over_triangles(|point| {
        pad.background_s_per_m * conductivity_factor(&presses, pad.touch_sign, point)
    });
    let fields = model.solve(&conductivity)?;
    let noise = 10f64.powf(-snr_db / 20.0);
    let deviations: Vec<f64> = fields
        .voltages(&pad.protocol)
        .iter()
        .map(|volt| volt.abs() * noise)
        .collect();
    let touched = PressedPad {
        model,
        fields: &fields,
        background: &background,
        presses: &presses,
        sign: pad.touch_sign,
    };
    match Slopes::new(&touched, pad).bounds(&deviations) {
        Some(bounds) => Ok(bounds[0].rms_mm()),
        None => Err(StudyError::refused(format!(
            "the voltages do not determine a touch at {:?} mm",
            press.centre_mm
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eit::Fields;
    use crate::eit::{ContactModel, Mesh, MeshSize};
    use crate::pad::TouchSign;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

    fn bound(variances: [f64; 3]) -> PressBound {
        PressBound {
            place_mm2: variances,
            volume_share: 0.1,
        }
    }

    #[test]
    fn mean_distances_are_those_of_known_laws() {
        // Round: Rayleigh's mean. A line: the mean of a half-normal, along any direction.
        let rayleigh = (std::f64::consts::PI / 2.0).sqrt();
        assert!((bound([4.0, 4.0, 0.0]).mean_mm() - 2.0 * rayleigh).abs() < 1e-12);
        let half_normal = (2.0 / std::f64::consts::PI).sqrt();
        for line in [[4.0, 0.0, 0.0], [2.0, 2.0, 2.0]] {
            assert!((bound(line).mean_mm() - 2.0 * half_normal).abs() < 2e-3);
        }
        assert!((bound([1.0, 3.0, 0.5]).rms_mm() - 2.0).abs() < 1e-12);
        let louder = bound([1.0, 3.0, 0.5]).with_noise(10.0);
        assert!(
            (louder.rms_mm() - 20.0).abs() < 1e-12 && (louder.volume_share - 1.0).abs() < 1e-12
        );
    }

    /// A pad with an uneven background, to be solved with presses.
    struct Bench {
        pad: Pad,
        model: ForwardModel,
        background: Vec<f64>,
    }

    impl Bench {
        fn new(touch_sign: TouchSign) -> Self {
            let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
            let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
            let mesh = Mesh::from_pad(&pad, MeshSize::reconstruction(&pad));
            let model = ForwardModel::new(mesh, &ContactModel::from_pad(&pad)).expect("solvable");
            let mesh = model.mesh();
            let background = (0..mesh.triangles.len())
                .map(|triangle| 1.0 + 0.001 * mesh.centroid_mm(triangle)[0])
                .collect();
            Self {
                pad: Pad { touch_sign, ..pad },
                model,
                background,
            }
        }

        fn fields(&self, presses: &[Press]) -> Fields {
            let mut conductivity = self.model.mesh().mean_over_triangles(|point| {
                conductivity_factor(presses, self.pad.touch_sign, point)
            });
            for (sigma, background) in conductivity.iter_mut().zip(&self.background) {
                *sigma *= background;
            }
            self.model.solve(&conductivity).expect("solved")
        }

        fn volts(&self, presses: &[Press]) -> Vec<f64> {
            self.fields(presses).voltages(&self.pad.protocol)
        }

        fn with<T>(&self, presses: &[Press], then: impl FnOnce(PressedPad) -> T) -> T {
            then(PressedPad {
                model: &self.model,
                fields: &self.fields(presses),
                background: &self.background,
                presses,
                sign: self.pad.touch_sign,
            })
        }
    }

    fn press(x: f64) -> Press {
        Press {
            centre_mm: [x, 40.0],
            radius_mm: 7.0,
            rise: 1.0,
        }
    }

    #[test]
    fn derivatives_are_those_of_the_forward_model() {
        for sign in [TouchSign::Rise, TouchSign::Fall] {
            let bench = Bench::new(sign);
            let presses = [press(30.0), press(40.0)];
            let exact = bench.with(&presses, |touched| Slopes::new(&touched, &bench.pad));
            let steps = [0.05, 0.05, 0.05, 0.01];
            for (unknown, step) in steps.into_iter().enumerate() {
                let volts = |by: f64| {
                    let [mut first, second] = presses;
                    match unknown {
                        0 | 1 => first.centre_mm[unknown] += by,
                        2 => first.radius_mm += by,
                        _ => first.rise += by,
                    }
                    bench.volts(&[first, second])
                };
                let (up, down) = (volts(step), volts(-step));
                let slopes = up
                    .iter()
                    .zip(&down)
                    .map(|(up, down)| (up - down) / (2.0 * step));
                let (mut off, mut all) = (0.0, 0.0);
                for (channel, slope) in slopes.enumerate() {
                    off += (exact.derivative[(channel, unknown)] - slope).powi(2);
                    all += slope * slope;
                }
                // Four points a triangle stand for its mean on one side, hundreds on the other.
                assert!(
                    off < 0.05f64.powi(2) * all,
                    "{sign:?}, {unknown}: {off} of {all}"
                );
            }
        }
    }

    #[test]
    fn a_second_unknown_press_costs_more_the_nearer_it_is() {
        let bench = Bench::new(TouchSign::Rise);
        let bound_mm = |presses: &[Press]| {
            let deviations: Vec<f64> = bench
                .volts(presses)
                .iter()
                .map(|volt| volt.abs() * 1e-3)
                .collect();
            bench
                .with(presses, |touched| Slopes::new(&touched, &bench.pad))
                .bounds(&deviations)
                .expect("determined")[0]
                .rms_mm()
        };
        let (alone, far, near) = (
            bound_mm(&[press(30.0)]),
            bound_mm(&[press(30.0), press(70.0)]),
            bound_mm(&[press(30.0), press(40.0)]),
        );
        assert!(alone < far && far < 1.5 * alone, "{alone} {far}");
        assert!(near > 2.0 * far, "{far} {near}");
    }
}
