//! The Cramer-Rao bound of a touch's place: how well any method, with this pad and this noise, could place a touch.
//!
//! Four unknowns: x, y, radius and rise of a press. The Fisher information is F = D' W D with D the exact derivative of the
//! voltages in the touched state (adjoint fields there times the derivative of the conductivity), W one over the variance
//! of each reading; the bound of the place is sqrt((F^-1)_xx + (F^-1)_yy). (Kay 1993, theorem 3.2.)

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::StudyError;
use crate::eit::{ForwardModel, element_jacobian};
use crate::pad::Pad;
use crate::types::PointMm;

/// A press as gels show it: the conductivity is multiplied by 1 + rise (1 - (d / radius)^2) within its radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// Its middle, mm.
    pub centre_mm: PointMm,
    /// Its radius, mm.
    pub radius_mm: f64,
    /// Relative rise in its middle.
    pub rise: f64,
}

impl Press {
    /// The factor at a point.
    #[must_use]
    pub fn factor(&self, point: PointMm) -> f64 {
        1.0 + self.rise * self.bump(point)
    }

    fn bump(&self, [x, y]: PointMm) -> f64 {
        let (dx, dy) = (x - self.centre_mm[0], y - self.centre_mm[1]);
        (1.0 - (dx * dx + dy * dy) / (self.radius_mm * self.radius_mm)).max(0.0)
    }

    /// Derivatives of the factor for x, y (1/mm), radius (1/mm) and rise.
    fn derivatives(&self, [x, y]: PointMm) -> [f64; 4] {
        let bump = self.bump([x, y]);
        if bump == 0.0 {
            return [0.0; 4];
        }
        let (dx, dy) = (x - self.centre_mm[0], y - self.centre_mm[1]);
        let r2 = self.radius_mm * self.radius_mm;
        [
            2.0 * self.rise * dx / r2,
            2.0 * self.rise * dy / r2,
            2.0 * self.rise * (1.0 - bump) / self.radius_mm,
            bump,
        ]
    }
}

/// The bound of a press' place, mm (root of the summed variances along x and y), for noise of an SNR (dB) in proportion to
/// each reading.
///
/// # Errors
/// A pad that cannot be solved, or a place that the voltages do not tell at all.
pub fn place_bound_mm(
    pad: &Pad,
    model: &ForwardModel,
    press: &Press,
    snr_db: f64,
) -> Result<f64, StudyError> {
    let background = pad.background_s_per_m;
    let mesh = model.mesh();
    let conductivity = mesh.mean_over_triangles(|point| background * press.factor(point));
    let fields = model.solve(&conductivity)?;
    let volts = fields.voltages(&pad.protocol);
    // Only the triangles under the press change with it.
    let under: Vec<(usize, [f64; 4])> = (0..mesh.triangles.len())
        .map(|triangle| {
            let mut mean = [0.0; 4];
            for point in mesh.quarter_points_mm(triangle) {
                for (sum, part) in mean.iter_mut().zip(press.derivatives(point)) {
                    *sum += part * background / 4.0;
                }
            }
            (triangle, mean)
        })
        .filter(|(_, mean)| *mean != [0.0; 4])
        .collect();
    let triangles: Vec<usize> = under.iter().map(|(triangle, _)| *triangle).collect();
    let jacobian = element_jacobian(model, &fields, &pad.protocol, &triangles);
    let noise = 10f64.powf(-snr_db / 20.0);
    let mut derivative = Mat::<f64>::zeros(volts.len(), 4);
    for (index, (_, mean)) in under.iter().enumerate() {
        for (channel, volt) in volts.iter().enumerate() {
            // Whitened: divided by the noise of that reading.
            let gain = jacobian[(channel, index)] / (volt * noise);
            for (parameter, part) in mean.iter().enumerate() {
                derivative[(channel, parameter)] += gain * part;
            }
        }
    }
    let information = derivative.transpose() * &derivative;
    let told = information
        .llt(Side::Lower)
        .map_err(|_| StudyError::Refused {
            reason: format!(
                "the voltages do not tell a touch at {:?} mm",
                press.centre_mm
            ),
        })?;
    let covariance = told.solve(Mat::<f64>::identity(4, 4));
    Ok((covariance[(0, 0)] + covariance[(1, 1)]).sqrt())
}
