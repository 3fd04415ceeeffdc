//! Large deformation of a body of bricks, some of whose nodes are moved to where they are told.
//!
//! Newton's method on the residual forces, the prescribed movement applied in steps: a step that does not converge is halved,
//! one that converges quickly is followed by a longer one.

use faer::Mat;

use super::bricks::{Bricks, GaussPoint, Point, gauss_points};
use super::rubber::{Answer, DOFS, Gradient, Rubber, answer, mean_gradient};
use super::system::{Size, System, SystemError};

/// Residual forces at which a step has converged, as a share of the forces at the prescribed nodes.
const CONVERGED: f64 = 1e-7;
/// Forces below this are no forces, mN.
const NO_FORCE_MN: f64 = 1e-9;
/// A step may take this many iterations.
const MOST_ITERATIONS: usize = 14;
/// After a step of at most so many iterations ...
const QUICK_ITERATIONS: usize = 6;
/// ... the next is this much longer.
const LONGER: f64 = 1.6;
/// A correction that turns a brick inside out is halved at most so often.
const MOST_HALVINGS: usize = 6;
/// The shortest step, as a share of the first.
const SHORTEST: f64 = 1.0 / 256.0;
/// No entry: one of the two unknowns is prescribed.
const NONE: u32 = u32::MAX;

/// What is told of one coordinate of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prescribed {
    /// The node.
    pub node: usize,
    /// 0, 1, 2: x, y, z.
    pub axis: usize,
    /// How far it has moved when the load is 1, mm.
    pub by_mm: f64,
}

/// Why a body could not be deformed so far.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ElasticError {
    /// Not even the shortest steps converged.
    #[error("the deformation does not converge beyond {reached:.3} of the load")]
    Diverged {
        /// The load that was reached.
        reached: f64,
    },
    /// Something may move freely, or too little memory.
    #[error("the body cannot be solved: {0}")]
    Unsolvable(&'static str),
}

/// A body, and how far it is deformed.
#[derive(Debug)]
pub struct Elastic {
    bricks: Bricks,
    points: Vec<[GaussPoint; 8]>,
    rubbers: Vec<Rubber>,
    prescribed: Vec<Prescribed>,
    /// Each node's unknowns; [`NONE`] where prescribed.
    unknowns: Vec<[u32; 3]>,
    system: System,
    /// Each brick's entries of the lower triangle.
    entries: Vec<Vec<u32>>,
    moved_mm: Vec<Point>,
    load: f64,
    step: f64,
}

/// Forces and, where wanted, stiffness of the whole body.
struct Assembled {
    values: Vec<f64>,
    residual: Vec<f64>,
    /// Forces on the nodes, mN.
    forces: Vec<Point>,
    /// Each brick's pressure, kPa, and its derivative, kPa/mm.
    pressures: Vec<(f64, [f64; DOFS])>,
}

impl Elastic {
    /// A body at rest, one rubber a brick. The first step takes this share of the load.
    ///
    /// # Errors
    /// Too little memory.
    pub fn new(
        bricks: Bricks,
        rubbers: Vec<Rubber>,
        prescribed: Vec<Prescribed>,
        first_step: f64,
    ) -> Result<Self, ElasticError> {
        let mut unknowns = vec![[0; 3]; bricks.nodes_mm.len()];
        for told in &prescribed {
            unknowns[told.node][told.axis] = NONE;
        }
        let mut count = 0;
        for unknown in unknowns.iter_mut().flatten() {
            if *unknown != NONE {
                *unknown = count;
                count += 1;
            }
        }
        let of_brick = |corners: &[u32; 8]| -> [u32; DOFS] {
            std::array::from_fn(|dof| unknowns[corners[dof / 3] as usize][dof % 3])
        };
        let groups: Vec<Vec<u32>> = bricks
            .corners
            .iter()
            .map(|corners| {
                of_brick(corners)
                    .into_iter()
                    .filter(|u| *u != NONE)
                    .collect()
            })
            .collect();
        let system = System::new(count as usize, groups.iter().map(Vec::as_slice))
            .map_err(|_| ElasticError::Unsolvable("it is too large for the memory"))?;
        let entries = bricks
            .corners
            .iter()
            .map(|corners| {
                let dofs = of_brick(corners);
                pairs()
                    .map(|(i, j)| match (dofs[i], dofs[j]) {
                        (NONE, _) | (_, NONE) => NONE,
                        (a, b) => system.entry(a, b),
                    })
                    .collect()
            })
            .collect();
        let points = (0..bricks.corners.len())
            .map(|brick| gauss_points(&bricks.corners_of(brick, &bricks.nodes_mm)))
            .collect();
        Ok(Self {
            moved_mm: vec![[0.0; 3]; bricks.nodes_mm.len()],
            load: 0.0,
            step: first_step,
            points,
            rubbers,
            prescribed,
            unknowns,
            system,
            entries,
            bricks,
        })
    }

    /// What one iteration takes.
    #[must_use]
    pub fn size(&self) -> Size {
        self.system.size()
    }

    /// The body at rest.
    #[must_use]
    pub fn bricks(&self) -> &Bricks {
        &self.bricks
    }

    /// How far each node has moved, mm.
    #[must_use]
    pub fn moved_mm(&self) -> &[Point] {
        &self.moved_mm
    }

    /// Deforms the body until the load is reached: every prescribed coordinate is then moved by that share.
    ///
    /// # Errors
    /// No convergence, or a body that is not held.
    pub fn load_to(&mut self, load: f64) -> Result<(), ElasticError> {
        let shortest = self.step * SHORTEST;
        while self.load < load {
            let next = if self.load + self.step > load - 1e-12 {
                load
            } else {
                self.load + self.step
            };
            let before = self.moved_mm.clone();
            match self.converge(next)? {
                Some(iterations) => {
                    self.load = next;
                    if iterations <= QUICK_ITERATIONS {
                        self.step *= LONGER;
                    }
                }
                None => {
                    self.moved_mm = before;
                    self.step = 0.5 * (next - self.load);
                    if self.step < shortest {
                        return Err(ElasticError::Diverged { reached: self.load });
                    }
                }
            }
        }
        Ok(())
    }

    /// How the body is stretched and turned about a point of it at rest: dx/dX at the nearest Gauss point, with the brick's
    /// mean change of volume, as the rubber has it.
    #[must_use]
    pub fn gradient_at(&self, point_mm: Point) -> Option<Gradient> {
        let (brick, point) = self.bricks.nearest(point_mm)?;
        let moved = self.bricks.corners_of(brick, &self.moved_mm);
        Some(mean_gradient(&self.points[brick], &moved, point))
    }

    /// The force with which nodes are held where they are, summed, N.
    #[must_use]
    pub fn holding_force_n(&self, nodes: &[usize]) -> Point {
        let forces = self
            .assemble(&self.moved_mm, false, &[], None)
            .map(|assembled| assembled.forces)
            .unwrap_or_default();
        std::array::from_fn(|axis| {
            nodes
                .iter()
                .filter_map(|node| forces.get(*node))
                .map(|f| f[axis])
                .sum::<f64>()
                * 1e-3
        })
    }

    /// One step; how many iterations it took, or nothing if it did not converge.
    fn converge(&mut self, load: f64) -> Result<Option<usize>, ElasticError> {
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
                if let Some(next) = self.assemble(&moved, true, &[], Some(&foretold)) {
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
        }
        Ok(None)
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

    /// Forces at these displacements, and the stiffness if wanted; `ahead` moves prescribed coordinates on to first order.
    /// Nothing if a brick is turned inside out.
    fn assemble(
        &self,
        moved_mm: &[Point],
        with_stiffness: bool,
        ahead: &[(usize, usize, f64)],
        foretold_kpa: Option<&[f64]>,
    ) -> Option<Assembled> {
        let count = self
            .unknowns
            .iter()
            .flatten()
            .filter(|u| **u != NONE)
            .count();
        let entries = if with_stiffness {
            self.system.entries()
        } else {
            0
        };
        let mut out = Assembled {
            values: vec![0.0; entries],
            residual: vec![0.0; count],
            forces: vec![[0.0; 3]; moved_mm.len()],
            pressures: Vec::with_capacity(self.bricks.corners.len()),
        };
        let mut by = vec![[0.0; 3]; if ahead.is_empty() { 0 } else { moved_mm.len() }];
        for (node, axis, mm) in ahead {
            by[*node][*axis] = *mm;
        }
        for (brick, corners) in self.bricks.corners.iter().enumerate() {
            let moved = self.bricks.corners_of(brick, moved_mm);
            let foretold = foretold_kpa.map(|foretold| foretold[brick]);
            let Answer {
                forces,
                stiffness,
                pressure_kpa,
                pressure_slope,
            } = answer(&self.points[brick], &moved, self.rubbers[brick], foretold)?;
            out.pressures.push((pressure_kpa, pressure_slope));
            for (dof, force) in forces.iter().enumerate() {
                let node = corners[dof / 3] as usize;
                out.forces[node][dof % 3] += force;
                let unknown = self.unknowns[node][dof % 3];
                if unknown == NONE {
                    continue;
                }
                let residual = &mut out.residual[unknown as usize];
                *residual += force;
                if !by.is_empty() {
                    for (column, slope) in stiffness[dof].iter().enumerate() {
                        *residual += slope * by[corners[column / 3] as usize][column % 3];
                    }
                }
            }
            if with_stiffness {
                for ((i, j), entry) in pairs().zip(&self.entries[brick]) {
                    if *entry != NONE {
                        out.values[*entry as usize] += stiffness[i][j];
                    }
                }
            }
        }
        Some(out)
    }
}

/// Pairs of a brick's unknowns, the lower triangle.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..DOFS).flat_map(|i| (0..=i).map(move |j| (i, j)))
}
