//! Large deformation of a body of bricks, some of whose nodes are moved to where they are told: what it is made of, its forces
//! and its stiffness. How it comes to its equilibrium: `newton`.

use super::bricks::{Bricks, CORNERS, GaussPoint, Point, gauss_points};
use super::rubber::{Answer, DOFS, Gradient, Rubber, answer, mean_gradient};
use super::system::{Size, System};

/// No entry: one of the two unknowns is prescribed.
pub(super) const NONE: u32 = u32::MAX;

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
    /// Neither did the shortest step converge, nor did the body come to rest when it was let creep.
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
    pub(super) bricks: Bricks,
    points: Vec<[GaussPoint; 8]>,
    pub(super) rubbers: Vec<Rubber>,
    pub(super) prescribed: Vec<Prescribed>,
    /// Each node's unknowns; [`NONE`] where prescribed.
    pub(super) unknowns: Vec<[u32; 3]>,
    pub(super) system: System,
    /// Each brick's entries of the lower triangle.
    entries: Vec<Vec<u32>>,
    /// What part of the body each unknown carries along, mm^3, and its entry of the diagonal.
    pub(super) carried: Vec<(f64, u32)>,
    pub(super) moved_mm: Vec<Point>,
    pub(super) load: f64,
    pub(super) step: f64,
}

/// Forces and, where wanted, stiffness of the whole body.
pub(super) struct Assembled {
    pub(super) values: Vec<f64>,
    pub(super) residual: Vec<f64>,
    /// Forces on the nodes, mN.
    pub(super) forces: Vec<Point>,
    /// Each brick's pressure, kPa, and its derivative, kPa/mm.
    pub(super) pressures: Vec<(f64, [f64; DOFS])>,
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
        let points: Vec<[GaussPoint; 8]> = (0..bricks.corners.len())
            .map(|brick| gauss_points(&bricks.corners_of(brick, &bricks.nodes_mm)))
            .collect();
        let mut carried: Vec<(f64, u32)> = (0..count)
            .map(|unknown| (0.0, system.entry(unknown, unknown)))
            .collect();
        for (corners, points) in bricks.corners.iter().zip(&points) {
            let volume: f64 = points.iter().map(|point| point.volume_mm3).sum();
            for unknown in of_brick(corners).into_iter().filter(|u| *u != NONE) {
                carried[unknown as usize].0 += volume / CORNERS as f64;
            }
        }
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
            carried,
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

    /// Forces at these displacements, and the stiffness if wanted; `ahead` moves prescribed coordinates on to first order.
    /// Nothing if a brick is turned inside out.
    pub(super) fn assemble(
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
