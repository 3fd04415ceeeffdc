//! A pad as manufactured: unequal contacts and uneven gel, unknown to the model that reconstructs images, and solved on another
//! mesh. All voltages of a specimen come from one such pad.

use super::draws::Draws;
use crate::eit::{ContactModel, Fields, ForwardError, ForwardModel, Mesh, MeshSize, PressedPad};
use crate::pad::Pad;
use crate::study::{Press, Slopes, conductivity_factor};
use crate::types::PointMm;

/// Contact impedances are uniform within this share of the pad's value.
const CONTACT_SPREAD: f64 = 0.3;
/// Waves of the uneven background.
const WAVES: usize = 4;
/// Standard deviation of the relative amplitude of a wave; together they make a few percent.
const WAVE_AMPLITUDE_SD: f64 = 0.02;
/// Most periods of a wave along a side: unevenness from mixing and drying is wide.
const MOST_PERIODS: f64 = 1.5;

/// A pad and its readings at rest.
#[derive(Clone, Debug)]
pub(in crate::study) struct Specimen {
    pub model: ForwardModel,
    /// Conductivity of each triangle at rest, S/m.
    pub background: Vec<f64>,
    /// Readings at rest, V/A.
    pub rest: Vec<f64>,
}

impl Specimen {
    /// A random pad on a mesh other than the reconstruction's.
    pub(super) fn random(pad: &Pad, draws: &mut Draws) -> Result<Self, ForwardError> {
        let even = ContactModel::from_pad(pad);
        let contacts = ContactModel {
            impedance_ohm_m2: even
                .impedance_ohm_m2
                .iter()
                .map(|impedance| {
                    impedance * draws.between(1.0 - CONTACT_SPREAD, 1.0 + CONTACT_SPREAD)
                })
                .collect(),
            ..even
        };
        let mesh = Mesh::from_pad(pad, MeshSize::simulation(pad));
        let waves: Vec<Wave> = (0..WAVES).map(|_| Wave::random(pad, draws)).collect();
        let background = (0..mesh.triangles.len())
            .map(|triangle| {
                let point = mesh.centroid_mm(triangle);
                let amplitude: f64 = waves.iter().map(|wave| wave.at(point)).sum();
                pad.conductivity_at(point) * libm::exp(amplitude)
            })
            .collect();
        Self::new(pad, mesh, &contacts, background)
    }

    /// The pad as the model that reconstructs images assumes it.
    pub(in crate::study) fn ideal(pad: &Pad) -> Result<Self, ForwardError> {
        let mesh = Mesh::from_pad(pad, MeshSize::reconstruction(pad));
        let background = mesh.background_s_per_m(pad);
        Self::new(pad, mesh, &ContactModel::from_pad(pad), background)
    }

    pub(super) fn new(
        pad: &Pad,
        mesh: Mesh,
        contacts: &ContactModel,
        background: Vec<f64>,
    ) -> Result<Self, ForwardError> {
        let model = ForwardModel::new(mesh, contacts)?;
        let rest = model.solve(&background)?.voltages(&pad.protocol);
        Ok(Self {
            model,
            background,
            rest,
        })
    }

    /// The fields with the conductivity multiplied by a factor at each point.
    pub(super) fn touched(&self, factor: impl Fn(PointMm) -> f64) -> Result<Fields, ForwardError> {
        let mut conductivity = self.model.mesh().mean_over_triangles(factor);
        for (sigma, background) in conductivity.iter_mut().zip(&self.background) {
            *sigma *= background;
        }
        self.model.solve(&conductivity)
    }

    /// The readings under presses, V/A, and their derivatives by the unknowns of the presses.
    pub(in crate::study) fn pressed(
        &self,
        pad: &Pad,
        presses: &[Press],
    ) -> Result<(Vec<f64>, Slopes), ForwardError> {
        let fields = self.touched(|point| conductivity_factor(presses, pad.touch_sign, point))?;
        let touched = PressedPad {
            model: &self.model,
            fields: &fields,
            background: &self.background,
            presses,
            sign: pad.touch_sign,
        };
        Ok((fields.voltages(&pad.protocol), Slopes::new(&touched, pad)))
    }
}

/// A plane wave over the pad.
struct Wave {
    amplitude: f64,
    wave_vector_rad_per_mm: [f64; 2],
    phase: f64,
}

impl Wave {
    fn random(pad: &Pad, draws: &mut Draws) -> Self {
        let size = pad.outline.size_mm();
        let amplitude = WAVE_AMPLITUDE_SD * draws.normal();
        let wave_vector_rad_per_mm = size.map(|length| {
            std::f64::consts::TAU * draws.between(-MOST_PERIODS, MOST_PERIODS) / length
        });
        Self {
            amplitude,
            wave_vector_rad_per_mm,
            phase: draws.angle(),
        }
    }

    fn at(&self, [x, y]: PointMm) -> f64 {
        // A cosine of amplitude 1 has a standard deviation of 1 / sqrt 2.
        let phase =
            self.wave_vector_rad_per_mm[0] * x + self.wave_vector_rad_per_mm[1] * y + self.phase;
        std::f64::consts::SQRT_2 * self.amplitude * libm::cos(phase)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};
    use crate::stats::rms;

    #[test]
    fn specimens_differ_by_a_few_percent_and_are_reproducible() {
        let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let drawn =
            |stream| Specimen::random(&pad, &mut Draws::new(&pad, 1, stream)).expect("solvable");
        let (one, other) = (drawn(1), drawn(2));
        assert_eq!(one.rest, drawn(1).rest);
        let off = |a: &[f64], b: &[f64]| rms(a.iter().zip(b).map(|(a, b)| a / b - 1.0));
        let apart = off(&one.rest, &other.rest);
        assert!((0.005..0.15).contains(&apart), "{apart}");
        let uneven = off(
            &one.background,
            &vec![pad.background_s_per_m; one.background.len()],
        );
        assert!((0.005..0.12).contains(&uneven), "{uneven}");
    }
}
