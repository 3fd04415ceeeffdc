//! Estimates memory and run time of a thickness study from the sizes of its systems, without solving one.

use super::solve::unsolvable;
use super::{Case, StudyError, Thickness, Touch, body};
use crate::study::solid::Size;

/// Multiplications and additions per second on one core.
const FLOPS_PER_S: f64 = 1.6e10;

/// Typical iterations of a case. The estimate of the run time depends on the kind of touch: on a table the rubber folds, and
/// each fold takes many steps.
fn iterations(touch: Touch) -> f64 {
    match touch {
        Touch::Rise => 0.0,
        Touch::Edge | Touch::Foundation => 25.0,
        Touch::Table => 70.0,
    }
}

/// The estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResourceEstimate {
    /// Unknowns of the largest system.
    pub unknowns: usize,
    /// Memory, bytes.
    pub bytes: f64,
    /// Run time on an idle machine, s; within a factor of about 2, depending on the processor.
    pub seconds: f64,
}

impl Thickness {
    /// Estimates the study with `at_a_time` cases in parallel.
    ///
    /// # Errors
    /// A sensor that cannot be built.
    pub fn estimate(&self, at_a_time: usize) -> Result<ResourceEstimate, StudyError> {
        let layers = self.cases.iter().map(|case| case.layer_mm);
        let layer_mm = layers.fold(0.0, f64::max);
        // Cases of a kind cost the same: one is sized, in the thickest layer.
        let mut kinds: Vec<(Case, f64)> = Vec::new();
        for case in &self.cases {
            let same =
                |(kind, _): &&mut (Case, f64)| kind.touch == case.touch && kind.finer == case.finer;
            match kinds.iter_mut().find(same) {
                Some((_, count)) => *count += 1.0,
                None => kinds.push((Case { layer_mm, ..*case }, 1.0)),
            }
        }
        let (mut unknowns, mut bytes, mut flops) = (0, 0.0_f64, 0.0);
        for (case, count) in &kinds {
            let current = self.current(layer_mm, case.finer)?.size();
            let (body, solves) = if case.touch == Touch::Rise {
                (Size::default(), 2.0)
            } else {
                let body =
                    body::size(&self.body(case)).map_err(|error| unsolvable(case, &error))?;
                (body, 1.0 + self.depths(case).0.len() as f64)
            };
            flops += count * (iterations(case.touch) * body.flops + solves * current.flops);
            unknowns = unknowns.max(body.unknowns).max(current.unknowns);
            bytes = bytes.max(body.bytes + current.bytes);
        }
        Ok(ResourceEstimate {
            unknowns,
            bytes: at_a_time as f64 * bytes,
            seconds: flops / FLOPS_PER_S / at_a_time as f64,
        })
    }
}
