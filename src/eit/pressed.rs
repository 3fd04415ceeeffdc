//! A pad in its touched state: how its readings depend on the presses.

use faer::Mat;

use super::forward::{Fields, ForwardModel};
use super::jacobian::element_jacobian;
use super::press::{PRESS_UNKNOWNS, Press, conductivity_factor};
use crate::pad::{Protocol, TouchSign};
use crate::types::PointMm;

/// A pad in its touched state, solved.
#[derive(Clone, Copy, Debug)]
pub struct PressedPad<'a> {
    /// The forward model.
    pub model: &'a ForwardModel,
    /// The solution.
    pub fields: &'a Fields,
    /// Conductivity of each triangle without the presses, S/m.
    pub background: &'a [f64],
    /// The presses.
    pub presses: &'a [Press],
    /// Whether they raise or lower the conductivity.
    pub sign: TouchSign,
}

impl PressedPad<'_> {
    /// Derivatives of the readings by x, y, radius (1/mm) and rise of each press: channels x unknowns, V/A.
    ///
    /// The exact derivative of the voltages in the touched state: adjoint fields times the derivative of the conductivity.
    #[must_use]
    pub fn slopes(&self, protocol: &Protocol) -> Mat<f64> {
        let under = self.under();
        let triangles: Vec<usize> = under.iter().map(|(triangle, _)| *triangle).collect();
        let jacobian = element_jacobian(self.model, self.fields, protocol, &triangles);
        let unknowns = PRESS_UNKNOWNS * self.presses.len();
        jacobian * Mat::from_fn(under.len(), unknowns, |row, unknown| under[row].1[unknown])
    }

    /// The triangles under the presses, with the derivatives of their conductivity by every unknown.
    fn under(&self) -> Vec<(usize, Vec<f64>)> {
        let mesh = self.model.mesh();
        (0..mesh.triangles.len())
            .filter_map(|triangle| {
                let points = mesh.quarter_points_mm(triangle);
                let is_under =
                    |point: &PointMm| self.presses.iter().any(|p| p.rise_share(*point) > 0.0);
                points.iter().any(is_under).then(|| {
                    let mut mean = vec![0.0; PRESS_UNKNOWNS * self.presses.len()];
                    for point in points {
                        let level = self.background[triangle]
                            * conductivity_factor(self.presses, self.sign, point)
                            / 4.0;
                        for (part, press) in mean.chunks_exact_mut(PRESS_UNKNOWNS).zip(self.presses)
                        {
                            let gain = f64::from(self.sign.factor()) * level / press.factor(point);
                            for (sum, slope) in part.iter_mut().zip(press.derivatives(point)) {
                                *sum += gain * slope;
                            }
                        }
                    }
                    (triangle, mean)
                })
            })
            .collect()
    }
}
