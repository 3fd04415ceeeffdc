//! Large deformation of a body of bricks with Dirichlet constraints: materials, forces and stiffness. `newton` finds the
//! equilibrium.

use super::bricks::{Bricks, CORNERS, GaussPoint, Point, gauss_points};
use super::rubber::{DOFS, DofVector, Gradient, Rubber, mean_gradient, respond};
use super::system::{Size, System};

/// In place of an unknown or an entry: the degree of freedom is constrained.
pub(super) const NONE: u32 = u32::MAX;

/// A Dirichlet constraint on one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constraint {
    /// The node.
    pub node: usize,
    /// 0, 1, 2: x, y, z.
    pub axis: usize,
    /// Displacement at a load of 1, mm.
    pub by_mm: f64,
}

/// Why no equilibrium was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ElasticError {
    /// The shortest step did not converge, and the body did not come to rest by creeping.
    #[error("the deformation does not converge beyond {reached:.3} of the load")]
    Diverged {
        /// The largest load with an equilibrium.
        reached: f64,
    },
    /// Part of the body can move freely, or there is too little memory.
    #[error("the body cannot be solved: {0}")]
    Unsolvable(&'static str),
}

/// A body and its state of deformation.
#[derive(Debug)]
pub struct Elastic {
    pub(super) bricks: Bricks,
    points: Vec<[GaussPoint; 8]>,
    pub(super) rubbers: Vec<Rubber>,
    pub(super) constraints: Vec<Constraint>,
    /// Unknowns of each node; [`NONE`] where constrained.
    pub(super) unknowns: Vec<[u32; 3]>,
    pub(super) system: System,
    /// Entries of each brick in the lower triangle.
    entries: Vec<Vec<u32>>,
    /// For each unknown, the volume of the body that moves with it, mm3, and its entry on the diagonal.
    pub(super) carried: Vec<(f64, u32)>,
    pub(super) moved_mm: Vec<Point>,
    pub(super) load: f64,
    pub(super) step: f64,
}

/// Forces and stiffness of the whole body.
pub(super) struct Assembled {
    /// Entries of the stiffness matrix, mN/mm.
    pub(super) values: Vec<f64>,
    /// Force on each unknown, mN.
    pub(super) residual: Vec<f64>,
    /// Force on each node, mN.
    pub(super) forces: Vec<Point>,
    /// Pressure of each brick, kPa, and its derivative, kPa/mm.
    pub(super) pressures: Vec<(f64, DofVector)>,
}

impl Elastic {
    /// A body at rest with a material for each brick. `first_step` is a share of the load.
    ///
    /// # Errors
    /// Too little memory.
    pub fn new(
        bricks: Bricks,
        rubbers: Vec<Rubber>,
        constraints: Vec<Constraint>,
        first_step: f64,
    ) -> Result<Self, ElasticError> {
        let (unknowns, count) = number_unknowns(bricks.nodes_mm.len(), &constraints);
        let dofs: Vec<[u32; DOFS]> = bricks
            .corners
            .iter()
            .map(|corners| std::array::from_fn(|dof| unknowns[corners[dof / 3] as usize][dof % 3]))
            .collect();
        let free = |dofs: &[u32; DOFS]| dofs.iter().copied().filter(|u| *u != NONE).collect();
        let groups: Vec<Vec<u32>> = dofs.iter().map(free).collect();
        let system = System::new(count, groups.iter().map(Vec::as_slice))
            .map_err(|_| ElasticError::Unsolvable("it is too large for the memory"))?;
        let entry = |dofs: &[u32; DOFS], (i, j): (usize, usize)| match (dofs[i], dofs[j]) {
            (NONE, _) | (_, NONE) => NONE,
            (a, b) => system.entry(a, b),
        };
        let entries = dofs
            .iter()
            .map(|dofs| pairs().map(|pair| entry(dofs, pair)).collect())
            .collect();
        let points: Vec<[GaussPoint; 8]> = (0..bricks.corners.len())
            .map(|brick| gauss_points(&bricks.corners_of(brick, &bricks.nodes_mm)))
            .collect();
        let mut carried: Vec<(f64, u32)> = (0..count as u32)
            .map(|unknown| (0.0, system.entry(unknown, unknown)))
            .collect();
        for (group, points) in groups.iter().zip(&points) {
            let volume: f64 = points.iter().map(|point| point.volume_mm3).sum();
            for unknown in group {
                carried[*unknown as usize].0 += volume / CORNERS as f64;
            }
        }
        Ok(Self {
            moved_mm: vec![[0.0; 3]; bricks.nodes_mm.len()],
            load: 0.0,
            step: first_step,
            points,
            rubbers,
            constraints,
            unknowns,
            system,
            entries,
            carried,
            bricks,
        })
    }

    /// Cost of one iteration.
    #[must_use]
    pub fn size(&self) -> Size {
        self.system.size()
    }

    /// The body at rest.
    #[must_use]
    pub fn bricks(&self) -> &Bricks {
        &self.bricks
    }

    /// Displacement of each node, mm.
    #[must_use]
    pub fn moved_mm(&self) -> &[Point] {
        &self.moved_mm
    }

    /// The deformation gradient dx/dX at the Gauss point nearest to a point of the body at rest, with the brick's mean change
    /// of volume.
    #[must_use]
    pub fn gradient_at(&self, point_mm: Point) -> Option<Gradient> {
        let (brick, point) = self.bricks.nearest(point_mm)?;
        let moved = self.bricks.corners_of(brick, &self.moved_mm);
        Some(mean_gradient(&self.points[brick], &moved, point))
    }

    /// The sum of the forces that hold these nodes in place, N.
    #[must_use]
    pub fn holding_force_n(&self, nodes: &[usize]) -> Point {
        let forces = self
            .assemble(&self.moved_mm, false, &[], None)
            .map(|assembled| assembled.forces)
            .unwrap_or_default();
        let held = || nodes.iter().filter_map(|node| forces.get(*node));
        std::array::from_fn(|axis| held().map(|force| force[axis]).sum::<f64>() * 1e-3)
    }

    /// Forces at these displacements, and the stiffness if wanted. `ahead` (node, axis, mm) moves constrained degrees of
    /// freedom to first order. `None` if a brick is turned inside out.
    pub(super) fn assemble(
        &self,
        moved_mm: &[Point],
        with_stiffness: bool,
        ahead: &[(usize, usize, f64)],
        predicted_kpa: Option<&[f64]>,
    ) -> Option<Assembled> {
        let entries = if with_stiffness {
            self.system.entries()
        } else {
            0
        };
        let mut out = Assembled {
            values: vec![0.0; entries],
            residual: vec![0.0; self.carried.len()],
            forces: vec![[0.0; 3]; moved_mm.len()],
            pressures: Vec::with_capacity(self.bricks.corners.len()),
        };
        let mut steps = vec![[0.0; 3]; if ahead.is_empty() { 0 } else { moved_mm.len() }];
        for (node, axis, mm) in ahead {
            steps[*node][*axis] = *mm;
        }
        for (brick, corners) in self.bricks.corners.iter().enumerate() {
            let moved = self.bricks.corners_of(brick, moved_mm);
            let predicted = predicted_kpa.map(|pressures| pressures[brick]);
            let response = respond(&self.points[brick], &moved, self.rubbers[brick], predicted)?;
            let mut residual = response.forces;
            if !steps.is_empty() {
                let steps = self.bricks.corners_of(brick, &steps);
                residual += response.stiffness * DofVector::from_column_slice(steps.as_slice());
            }
            for dof in 0..DOFS {
                let node = corners[dof / 3] as usize;
                out.forces[node][dof % 3] += response.forces[dof];
                let unknown = self.unknowns[node][dof % 3];
                if unknown != NONE {
                    out.residual[unknown as usize] += residual[dof];
                }
            }
            if with_stiffness {
                for (pair, entry) in pairs().zip(&self.entries[brick]) {
                    if *entry != NONE {
                        out.values[*entry as usize] += response.stiffness[pair];
                    }
                }
            }
            out.pressures
                .push((response.pressure_kpa, response.pressure_slope));
        }
        Some(out)
    }
}

/// Numbers the unconstrained degrees of freedom; also returns their count.
fn number_unknowns(nodes: usize, constraints: &[Constraint]) -> (Vec<[u32; 3]>, usize) {
    let mut unknowns = vec![[0; 3]; nodes];
    for constraint in constraints {
        unknowns[constraint.node][constraint.axis] = NONE;
    }
    let mut count = 0;
    for unknown in unknowns.iter_mut().flatten().filter(|u| **u != NONE) {
        *unknown = count;
        count += 1;
    }
    (unknowns, count as usize)
}

/// Pairs of a brick's degrees of freedom, the lower triangle.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..DOFS).flat_map(|i| (0..=i).map(move |j| (i, j)))
}
