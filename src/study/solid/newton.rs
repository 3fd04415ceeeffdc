//! How a body comes to its equilibrium.
//!
//! Newton's method on the residual forces, the prescribed movement applied in steps: a step that does not converge is halved,
//! one that converges quickly is followed by a longer one. Where the equilibrium ends (soft rubber folds, an arch snaps) no
//! step is short enough: there the body is let creep down its energy until it rests in another one.

use faer::Mat;

use super::bricks::Point;
use super::elastic::{Assembled, Elastic, ElasticError, NONE};
use super::system::SystemError;

/// Residual forces at which a step has converged, as a share of the forces at the prescribed nodes.
const CONVERGED: f64 = 1e-7;
/// Forces below this are no forces, mN.
const NO_FORCE_MN: f64 = 1e-9;
/// A step may take this many iterations ...
const MOST_ITERATIONS: usize = 14;
/// ... and after so many ...
const PATIENCE: usize = 6;
/// ... the residual must have fallen to this share of the first's, or there is nothing near to converge to.
const HOPEFUL: f64 = 1e-2;
/// After a step of at most so many iterations ...
const QUICK_ITERATIONS: usize = 6;
/// ... the next is this much longer.
const LONGER: f64 = 1.6;
/// After a step that did not converge, so many have to before one is longer again.
const CAUTION: usize = 3;
/// A correction that turns a brick inside out is halved at most so often.
const MOST_HALVINGS: usize = 2;
/// The shortest step, as a share of the one with which a load begins; if it does not converge the body is let creep.
const SHORTEST: f64 = 1.0 / 32.0;
/// What holds a creeping body back at first, as a share of the stiffest rubber's shear modulus, a mm^2.
const FIRST_DRAG: f64 = 0.2;
/// Drag falls by this factor after a quick step, rises by it after one that did not converge, ...
const DRAG_FACTOR: f64 = 4.0;
/// ... and where so few iterations follow its movement, an equilibrium without drag is near.
const AT_REST: usize = 2;
/// A body has so many steps to come to rest.
const MOST_CREEPING: usize = 60;

/// A drag on every part of a body.
struct Drag<'a> {
    /// Where its nodes' movement is counted from, mm.
    from: &'a [Point],
    /// Force on a volume that has moved, mN/mm^4.
    drag: f64,
}

impl Elastic {
    /// Deforms the body until the load is reached: every prescribed coordinate is then moved by that share.
    ///
    /// # Errors
    /// No equilibrium, not even by creeping, or a body that is not held.
    pub fn load_to(&mut self, load: f64) -> Result<(), ElasticError> {
        let shortest = self.step * SHORTEST;
        let mut caution = 0_usize;
        while self.load < load {
            let next = if self.load + self.step > load - 1e-12 {
                load
            } else {
                self.load + self.step
            };
            let before = self.moved_mm.clone();
            if let Some(iterations) = self.converge(next, None)? {
                self.load = next;
                if iterations <= QUICK_ITERATIONS && caution == 0 {
                    self.step *= LONGER;
                }
                caution = caution.saturating_sub(1);
                continue;
            }
            self.moved_mm = before;
            caution = CAUTION;
            let step = next - self.load;
            if step > 2.0 * shortest {
                self.step = 0.5 * step;
            } else if self.creep(next)? {
                self.load = next;
                self.step = 4.0 * step;
            } else {
                return Err(ElasticError::Diverged { reached: self.load });
            }
        }
        Ok(())
    }

    /// Lets a body that has lost its equilibrium (a fold snaps) move under this load against a drag until it rests in another
    /// one: implicit steps down the energy, longer and longer. Whether it came to rest.
    fn creep(&mut self, load: f64) -> Result<bool, ElasticError> {
        let stiffest = self.rubbers.iter().map(|rubber| rubber.shear_kpa);
        let first = FIRST_DRAG * stiffest.fold(0.0, f64::max);
        let mut drag = first;
        let mut caution = 0_usize;
        for _ in 0..MOST_CREEPING {
            let from = self.moved_mm.clone();
            let came = self.converge(load, Some(&Drag { from: &from, drag }))?;
            match came {
                Some(iterations) if iterations <= AT_REST => {
                    let crept = self.moved_mm.clone();
                    if self.converge(load, None)?.is_some() {
                        return Ok(true);
                    }
                    self.moved_mm = crept;
                    drag /= DRAG_FACTOR;
                }
                Some(iterations) if iterations <= QUICK_ITERATIONS && caution == 0 => {
                    drag /= DRAG_FACTOR;
                }
                Some(_) => caution = caution.saturating_sub(1),
                None => {
                    self.moved_mm = from;
                    drag *= DRAG_FACTOR;
                    caution = CAUTION;
                }
            }
        }
        Ok(false)
    }

    /// One step; how many iterations it took, or nothing if it did not converge.
    fn converge(
        &mut self,
        load: f64,
        drag: Option<&Drag<'_>>,
    ) -> Result<Option<usize>, ElasticError> {
        let ahead: Vec<(usize, usize, f64)> = self
            .prescribed
            .iter()
            .map(|told| {
                let there = load * told.by_mm;
                (
                    told.node,
                    told.axis,
                    there - self.moved_mm[told.node][told.axis],
                )
            })
            .collect();
        // The first correction carries the prescribed movement into the body as a linear one would.
        let Some(mut state) = self.assemble(&self.moved_mm, true, &ahead, None) else {
            return Ok(None);
        };
        self.hold_back(drag, &self.moved_mm, &mut state);
        let mut first_rest = None;
        for iteration in 1..=MOST_ITERATIONS {
            let correction = self.correction(&state)?;
            let mut share = 1.0;
            let mut halvings = 0;
            let (moved, next) = loop {
                let mut moved = self.moved_mm.clone();
                for (moved, unknowns) in moved.iter_mut().zip(&self.unknowns) {
                    for (coordinate, unknown) in moved.iter_mut().zip(unknowns) {
                        if *unknown != NONE {
                            *coordinate += share * correction[(*unknown as usize, 0)];
                        }
                    }
                }
                for told in &self.prescribed {
                    moved[told.node][told.axis] = load * told.by_mm;
                }
                let foretold = self.foretell(&state, &moved);
                if let Some(mut next) = self.assemble(&moved, true, &[], Some(&foretold)) {
                    self.hold_back(drag, &moved, &mut next);
                    break (moved, next);
                }
                halvings += 1;
                // The prescribed movement itself may be too long a step.
                if halvings > MOST_HALVINGS {
                    return Ok(None);
                }
                share *= 0.5;
            };
            self.moved_mm = moved;
            state = next;
            let held: f64 = self
                .prescribed
                .iter()
                .map(|told| state.forces[told.node][told.axis].powi(2))
                .sum();
            let rest: f64 = state.residual.iter().map(|force| force * force).sum();
            if !rest.is_finite() {
                return Ok(None);
            }
            if rest.sqrt() <= CONVERGED * held.sqrt() + NO_FORCE_MN {
                return Ok(Some(iteration));
            }
            let first = *first_rest.get_or_insert(rest.sqrt());
            if iteration >= PATIENCE && rest.sqrt() > HOPEFUL * first {
                break;
            }
        }
        Ok(None)
    }

    /// Adds the force of a drag on what has moved since, and its stiffness.
    fn hold_back(&self, drag: Option<&Drag<'_>>, moved_mm: &[Point], state: &mut Assembled) {
        let Some(Drag { from, drag }) = drag else {
            return;
        };
        let nodes = moved_mm.iter().zip(*from).zip(&self.unknowns);
        for ((moved, from), unknowns) in nodes {
            for axis in (0..3).filter(|axis| unknowns[*axis] != NONE) {
                let unknown = unknowns[axis] as usize;
                let (volume, diagonal) = self.carried[unknown];
                state.residual[unknown] += drag * volume * (moved[axis] - from[axis]);
                state.values[diagonal as usize] += drag * volume;
            }
        }
    }

    /// Each brick's pressure at new displacements as the last ones foretell it, kPa.
    fn foretell(&self, last: &Assembled, moved_mm: &[Point]) -> Vec<f64> {
        let bricks = self.bricks.corners.iter().zip(&last.pressures);
        bricks
            .map(|(corners, (pressure, slope))| {
                let steps = corners.iter().zip(slope.chunks(3)).map(|(node, slope)| {
                    let (new, old) = (moved_mm[*node as usize], self.moved_mm[*node as usize]);
                    (0..3)
                        .map(|axis| slope[axis] * (new[axis] - old[axis]))
                        .sum::<f64>()
                });
                pressure + steps.sum::<f64>()
            })
            .collect()
    }

    fn correction(&self, state: &Assembled) -> Result<Mat<f64>, ElasticError> {
        let unsolvable = |error: SystemError| {
            ElasticError::Unsolvable(match error {
                SystemError::Singular => "part of it is not held",
                SystemError::TooLarge => "it is too large for the memory",
            })
        };
        let mut side = Mat::from_fn(state.residual.len(), 1, |row, _| -state.residual[row]);
        self.system
            .factorise(&state.values)
            .and_then(|factor| factor.solve_in_place(side.as_mut()))
            .map_err(unsolvable)?;
        Ok(side)
    }
}
