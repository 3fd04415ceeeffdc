//! The responses of a pad that differs a little from its drawing, from those of the drawing.
//!
//! The drawing's symmetry saves most of the work of its table; a pad as built has none. But the two differ to first order only in the
//! linear part of a response, which the Jacobian gives cheaply, while saturation is that of the touch: the response is the drawing's,
//! plus the difference of the linear parts, reduced as much as saturation reduces the drawing's.

use std::sync::Arc;

use super::scatter::LinearResponses;
use super::table::ResponseTable;
use super::terms::{POWERS, SIGNS};
use super::touch_model::{HALF_RISE, Shape, TouchModel};
use crate::eit::SetupError;
use crate::pad::{Pad, TouchSign};

/// The drawing's table, and both pads' linear parts.
#[derive(Clone, Debug)]
pub(super) struct DerivedResponses {
    table: Arc<ResponseTable>,
    drawn: LinearResponses,
    found: LinearResponses,
}

impl DerivedResponses {
    /// Prepares a pad with the table of its drawing.
    ///
    /// # Errors
    /// A pad that cannot be solved.
    pub(super) fn new(pad: &Pad, table: Arc<ResponseTable>) -> Result<Self, SetupError> {
        Ok(Self {
            table,
            drawn: LinearResponses::new(&pad.drawing())?,
            found: LinearResponses::new(pad)?,
        })
    }

    /// The first-order part of the pad as found.
    pub(super) fn linear(&self) -> &LinearResponses {
        &self.found
    }

    /// Responses at a place for the radius with this index, divided by area and strength: signs x strengths x channels.
    pub(super) fn samples(
        &self,
        place: usize,
        radius: usize,
        strengths: &[f64; POWERS],
    ) -> Vec<f32> {
        let table = &self.table;
        let centre_mm = table.places.at_mm(place);
        let radius_mm = table.places.radii_mm()[radius];
        let drawn = self.drawn.per_rise(centre_mm, radius_mm);
        let found = self.found.per_rise(centre_mm, radius_mm);
        let own: f64 = drawn.iter().map(|change| change * change).sum();
        let mut samples = Vec::with_capacity(SIGNS * POWERS * drawn.len());
        let mut coordinates = Vec::new();
        let mut response = vec![0.0; table.channels];
        for sign in [TouchSign::Rise, TouchSign::Fall] {
            for strength in strengths {
                if *strength == 0.0 {
                    let scale = f64::from(sign.factor()) * HALF_RISE / (radius_mm * radius_mm);
                    samples.extend(found.iter().map(|change| (scale * change) as f32));
                    continue;
                }
                let touch = TouchModel {
                    centre_mm,
                    log_radius: libm::log(radius_mm),
                    strength: *strength,
                    sign,
                    shape: Shape::Round,
                };
                table.respond_value(&touch, &mut coordinates);
                let scale = (1.0 / (radius_mm * radius_mm * strength)) as f32;
                for value in &mut coordinates {
                    *value *= scale;
                }
                table.expand(&coordinates, &mut response);
                let along = drawn.iter().zip(&response).map(|(d, r)| d * f64::from(*r));
                let share = if own > 0.0 {
                    along.sum::<f64>() / own
                } else {
                    0.0
                };
                let changed = response.iter().zip(drawn.iter().zip(&found));
                samples.extend(changed.map(|(response, (drawn, found))| {
                    (f64::from(*response) + share * (found - drawn)) as f32
                }));
            }
        }
        samples
    }
}
