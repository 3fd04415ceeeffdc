//! Finds the equilibrium of a body.
//!
//! Newton's method on the residual forces, with the prescribed displacements applied in steps: a step that does not converge
//! is halved, one that converges quickly is followed by a longer one. Where the equilibrium ends (soft rubber folds, an arch
//! snaps through) no step is short enough. There the body creeps down its energy against a drag until it rests in another
//! equilibrium.

use faer::Mat;

use super::bricks::Point;
use super::elastic::{Assembled, Elastic, ElasticError, NONE};
use super::rubber::DofVector;
use super::system::SystemError;

/// Residual forces at which a step has converged, as a share of the forces at the constraints.
const CONVERGED: f64 = 1e-7;
/// Forces below this count as zero, mN.
const NO_FORCE_MN: f64 = 1e-9;
/// Most iterations of a step.
const MOST_ITERATIONS: usize = 14;
/// After this many iterations the residual must be below [`HOPEFUL`] of the first one, or the step is given up.
const PATIENCE: usize = 6;
/// See [`PATIENCE`].
const HOPEFUL: f64 = 1e-2;
/// A step that takes at most this many iterations makes the next one [`LONGER`] times as long.
const QUICK_ITERATIONS: usize = 6;
/// See [`QUICK_ITERATIONS`].
const LONGER: f64 = 1.6;
/// Steps that have to converge after one that did not, before a step is made longer again.
const CAUTION: usize = 3;
/// A correction that turns a brick inside out is halved at most this often.
const MOST_HALVINGS: usize = 2;
/// The shortest step, as a share of the first step of a load; if it does not converge, the body creeps.
const SHORTEST: f64 = 1.0 / 32.0;
/// First drag on a creeping body, as a share of the largest shear modulus, per mm2.
const FIRST_DRAG: f64 = 0.2;
/// Factor by which the drag falls after a quick step, and rises after one that did not converge.
const DRAG_FACTOR: f64 = 4.0;
/// A creeping step of at most this many iterations shows that an equilibrium without drag is near.
const AT_REST: usize = 2;
/// Most creeping steps until the body must be at rest.
const MOST_CREEPING: usize = 60;

/// A drag on every part of a body.
struct Drag<'a> {
    /// Displacements at which the drag is zero, mm.
    from: &'a [Point],
    /// Force on a volume that has moved, mN/mm4.
    drag: f64,
}

impl Elastic {
    /// Deforms the body until the load is reached: every constraint is then displaced by this share of its `by_mm`.
    ///
    /// # Errors
    /// No equilibrium, even by creeping; a body that can move freely.
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

    /// Moves a body that has lost its equilibrium against a drag until it rests in another one, by implicit steps down the
    /// energy that become longer and longer. Returns whether it came to rest.
    fn creep(&mut self, load: f64) -> Result<bool, ElasticError> {
        let moduli = self.rubbers.iter().map(|rubber| rubber.shear_kpa);
        let mut drag = FIRST_DRAG * moduli.fold(0.0, f64::max);
        let mut caution = 0_usize;
        for _ in 0..MOST_CREEPING {
            let from = self.moved_mm.clone();
            match self.converge(load, Some(&Drag { from: &from, drag }))? {
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

    /// Solves one step. Returns the number of iterations, or `None` if it did not converge.
    fn converge(
        &mut self,
        load: f64,
        drag: Option<&Drag<'_>>,
    ) -> Result<Option<usize>, ElasticError> {
        let ahead: Vec<(usize, usize, f64)> = self
            .constraints
            .iter()
            .map(|fixed| {
                let moved_mm = self.moved_mm[fixed.node][fixed.axis];
                (fixed.node, fixed.axis, load * fixed.by_mm - moved_mm)
            })
            .collect();
        // The first correction carries the prescribed displacements into the body as a linear model would.
        let Some(mut state) = self.assemble(&self.moved_mm, true, &ahead, None) else {
            return Ok(None);
        };
        self.add_drag(drag, &self.moved_mm, &mut state);
        let mut first_residual = None;
        for iteration in 1..=MOST_ITERATIONS {
            let Some((moved_mm, next)) = self.corrected(load, drag, &state)? else {
                return Ok(None);
            };
            self.moved_mm = moved_mm;
            state = next;
            let residual = norm(state.residual.iter().copied());
            let forces = self.constraints.iter();
            let held = norm(forces.map(|fixed| state.forces[fixed.node][fixed.axis]));
            if !residual.is_finite() {
                return Ok(None);
            }
            if residual <= CONVERGED * held + NO_FORCE_MN {
                return Ok(Some(iteration));
            }
            let first = *first_residual.get_or_insert(residual);
            if iteration >= PATIENCE && residual > HOPEFUL * first {
                break;
            }
        }
        Ok(None)
    }

    /// One iteration of Newton's method: the corrected displacements and the forces there. `None` if even a shortened
    /// correction turns a brick inside out.
    fn corrected(
        &self,
        load: f64,
        drag: Option<&Drag<'_>>,
        state: &Assembled,
    ) -> Result<Option<(Vec<Point>, Assembled)>, ElasticError> {
        let correction = self.correction(state)?;
        for halvings in 0..=MOST_HALVINGS as i32 {
            let share = 0.5_f64.powi(halvings);
            let mut moved_mm = self.moved_mm.clone();
            for (moved, unknowns) in moved_mm.iter_mut().zip(&self.unknowns) {
                for (coordinate, unknown) in moved.iter_mut().zip(unknowns) {
                    if *unknown != NONE {
                        *coordinate += share * correction[(*unknown as usize, 0)];
                    }
                }
            }
            for fixed in &self.constraints {
                moved_mm[fixed.node][fixed.axis] = load * fixed.by_mm;
            }
            let predicted = self.predicted_pressures_kpa(state, &moved_mm);
            if let Some(mut next) = self.assemble(&moved_mm, true, &[], Some(&predicted)) {
                self.add_drag(drag, &moved_mm, &mut next);
                return Ok(Some((moved_mm, next)));
            }
        }
        Ok(None)
    }

    /// Adds the force of a drag, and its stiffness.
    fn add_drag(&self, drag: Option<&Drag<'_>>, moved_mm: &[Point], state: &mut Assembled) {
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

    /// Pressure of each brick at new displacements, to first order from the last ones, kPa.
    fn predicted_pressures_kpa(&self, last: &Assembled, moved_mm: &[Point]) -> Vec<f64> {
        let bricks = last.pressures.iter().enumerate();
        bricks
            .map(|(brick, (pressure, slope))| {
                let [new, old] =
                    [moved_mm, &self.moved_mm].map(|moved| self.bricks.corners_of(brick, moved));
                pressure + slope.dot(&DofVector::from_column_slice((new - old).as_slice()))
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

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.map(|value| value * value).sum::<f64>().sqrt()
}
