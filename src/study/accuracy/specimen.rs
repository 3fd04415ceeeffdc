//! A pad as it comes out of the mould: contacts that are not alike, gel that is not even.
//!
//! The model that makes images knows neither, nor the mesh that is solved here. All voltages of one specimen come from one
//! such pad, as a player has one.

use super::draws::Draws;
use crate::eit::{ContactModel, Fields, ForwardError, ForwardModel, Mesh, MeshSize};
use crate::pad::Pad;
use crate::study::{Press, Slopes, Touched, pressed};
use crate::types::PointMm;

/// Contact impedances spread by this share about what the pad's text says, evenly.
const CONTACT_SPREAD: f64 = 0.3;
/// Waves of which the uneven background is made, and the deviation of each one's height: together a few percent.
const WAVES: (usize, f64) = (4, 0.02);
/// A wave has at most so many periods along a side: unevenness from mixing and drying is wide.
const MOST_PERIODS: f64 = 1.5;

/// One pad, solved at rest.
#[derive(Clone, Debug)]
pub(super) struct Specimen {
    pub model: ForwardModel,
    /// Conductivity of each triangle at rest, S/m.
    pub background: Vec<f64>,
    /// Readings at rest, V/A.
    pub rest: Vec<f64>,
}

impl Specimen {
    /// A random pad on a mesh other than the reconstruction's.
    pub(super) fn drawn(pad: &Pad, draws: &mut Draws) -> Result<Self, ForwardError> {
        let even = ContactModel::of_pad(pad);
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
        let mesh = Mesh::of_pad(pad, MeshSize::simulation(pad));
        let waves: Vec<Wave> = (0..WAVES.0).map(|_| Wave::drawn(pad, draws)).collect();
        let background = (0..mesh.triangles.len())
            .map(|triangle| {
                let point = mesh.centroid_mm(triangle);
                let height: f64 = waves.iter().map(|wave| wave.at(point)).sum();
                pad.background_s_per_m * libm::exp(height)
            })
            .collect();
        Self::of(pad, mesh, &contacts, background)
    }

    /// The pad exactly as the model that makes images takes it to be.
    pub(super) fn ideal(pad: &Pad) -> Result<Self, ForwardError> {
        let mesh = Mesh::of_pad(pad, MeshSize::reconstruction(pad));
        let background = vec![pad.background_s_per_m; mesh.triangles.len()];
        Self::of(pad, mesh, &ContactModel::of_pad(pad), background)
    }

    fn of(
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

    /// The fields while the conductivity is multiplied by a factor at each point.
    pub(super) fn touched(&self, factor: impl Fn(PointMm) -> f64) -> Result<Fields, ForwardError> {
        let mut conductivity = self.model.mesh().mean_over_triangles(factor);
        for (sigma, background) in conductivity.iter_mut().zip(&self.background) {
            *sigma *= background;
        }
        self.model.solve(&conductivity)
    }

    /// Its readings under presses, V/A, and what they say of the presses.
    pub(super) fn pressed(
        &self,
        pad: &Pad,
        presses: &[Press],
    ) -> Result<(Vec<f64>, Slopes), ForwardError> {
        let fields = self.touched(|point| pressed(presses, pad.touch_sign, point))?;
        let touched = Touched {
            model: &self.model,
            fields: &fields,
            background: &self.background,
            presses,
        };
        Ok((fields.voltages(&pad.protocol), touched.slopes(pad)))
    }
}

/// A plane wave over the pad.
struct Wave {
    height: f64,
    per_mm: [f64; 2],
    phase: f64,
}

impl Wave {
    fn drawn(pad: &Pad, draws: &mut Draws) -> Self {
        let size = pad.outline.size_mm();
        let height = WAVES.1 * draws.normal();
        let per_mm = size.map(|length| {
            std::f64::consts::TAU * draws.between(-MOST_PERIODS, MOST_PERIODS) / length
        });
        Self {
            height,
            per_mm,
            phase: draws.angle(),
        }
    }

    fn at(&self, [x, y]: PointMm) -> f64 {
        // A cosine of standard deviation 1 / sqrt 2 has an amplitude of 1.
        let phase = self.per_mm[0] * x + self.per_mm[1] * y + self.phase;
        std::f64::consts::SQRT_2 * self.height * libm::cos(phase)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, shipped_pad};

    #[test]
    fn specimens_differ_by_a_few_percent_and_the_same_draw_gives_the_same_one() {
        let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
        let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
        let drawn =
            |stream| Specimen::drawn(&pad, &mut Draws::new(&pad, 1, stream)).expect("solvable");
        let (one, other) = (drawn(1), drawn(2));
        assert_eq!(one.rest, drawn(1).rest);
        let off = |a: &[f64], b: &[f64]| {
            let squares: f64 = a.iter().zip(b).map(|(a, b)| (a / b - 1.0).powi(2)).sum();
            (squares / a.len() as f64).sqrt()
        };
        let apart = off(&one.rest, &other.rest);
        assert!((0.005..0.15).contains(&apart), "{apart}");
        let uneven = off(
            &one.background,
            &vec![pad.background_s_per_m; one.background.len()],
        );
        assert!((0.005..0.12).contains(&uneven), "{uneven}");
    }
}
