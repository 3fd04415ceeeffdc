//! What a thickness study will take, told before it begins: from the sizes of its systems, not by solving one.

use super::super::solid::Size;
use super::{Case, StudyError, Thickness, Touch, body, unsolvable};

/// Multiplications that a core does in a second.
const FLOPS_PER_S: f64 = 1.6e10;

/// Iterations that a case takes, so chosen that the whole study's time comes out: on a table the rubber folds, and each fold is
/// followed.
fn iterations(touch: Touch) -> f64 {
    match touch {
        Touch::Rise => 0.0,
        Touch::Edge | Touch::Foundation => 25.0,
        Touch::Table => 70.0,
    }
}

/// What a study will take.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foretold {
    /// Unknowns of the largest system.
    pub unknowns: usize,
    /// Memory, bytes.
    pub bytes: f64,
    /// Time on an idle machine, s; as good as a guess of a machine's speed can be.
    pub seconds: f64,
}

impl Thickness {
    /// What the study will take with so many cases at a time.
    ///
    /// # Errors
    /// A sensor that cannot be built.
    pub fn foretell(&self, at_a_time: usize) -> Result<Foretold, StudyError> {
        let layers = self.cases.iter().map(|case| case.layer_mm);
        let layer_mm = layers.fold(0.0, f64::max);
        // Cases of a kind cost alike: one is sized, in the thickest layer.
        let mut kinds: Vec<(Case, f64)> = Vec::new();
        for case in &self.cases {
            let alike =
                |(kind, _): &&mut (Case, f64)| kind.touch == case.touch && kind.finer == case.finer;
            match kinds.iter_mut().find(alike) {
                Some((_, count)) => *count += 1.0,
                None => kinds.push((Case { layer_mm, ..*case }, 1.0)),
            }
        }
        let (mut unknowns, mut bytes, mut work) = (0, 0.0_f64, 0.0);
        for (case, count) in &kinds {
            let current = self.current(layer_mm, case.finer)?.size();
            let (body, solves) = if case.touch == Touch::Rise {
                (Size::default(), 2.0)
            } else {
                let body =
                    body::size(&self.body(case)).map_err(|error| unsolvable(case, &error))?;
                (body, 1.0 + self.depths(case).0.len() as f64)
            };
            work += count * (iterations(case.touch) * body.flops + solves * current.flops);
            unknowns = unknowns.max(body.unknowns).max(current.unknowns);
            bytes = bytes.max(body.bytes + current.bytes);
        }
        Ok(Foretold {
            unknowns,
            bytes: at_a_time as f64 * bytes,
            seconds: work / FLOPS_PER_S / at_a_time as f64,
        })
    }
}
