//! The response of every channel to one touch, without solving the whole pad again.
//!
//! A touch changes the conductivity of a few triangles, so the new field follows from the old one by a system of their
//! nodes only: with K the stiffness of the untouched pad, D its change and S the nodes that D joins,
//! u'_S = (I + (K^-1)_SS D)^-1 u_S, and each reading changes by -u_drive' D u'_measure (Woodbury 1950; Hager 1989,
//! SIAM Review 31, eq. 2). This is exact for the mesh at any strength.
//!
//! K^-1 between all nodes fits in memory for a coarse mesh only. Nearly all error of a coarse mesh is in the linear part,
//! which the Jacobian of a fine mesh gives cheaply: the response is the fine mesh's linear part plus the difference between
//! the coarse mesh's exact and linear response. Both are of the coarse mesh's own fields, so that its errors cancel: with those of the fine
//! mesh at the coarse nodes, places come out worse (the median error over bound of docs/accuracy.md is 1.17 instead of 1.11).

use faer::Mat;
use faer::linalg::solvers::Solve;

use crate::eit::forward::{Fields, ForwardModel};
use crate::eit::jacobian::{element_jacobian, pair_sums};
use crate::eit::{ContactModel, Mesh, MeshSize, Press, SetupError};
use crate::pad::{Pad, Protocol, TouchSign};
use crate::types::PointMm;

/// Most nodes of the coarse mesh: its inverse takes 4 bytes per pair of nodes.
const MOST_NODES: usize = 4500;
/// The coarse mesh starts with edges this many times as long as the reconstruction's ...
const COARSE_SCALE: f64 = 2.0;
/// ... which grow by this factor until it has few enough nodes.
const COARSER: f64 = 1.15;
/// What the solution depends on beside the pad.
pub(super) const CONSTANTS: [f64; 3] = [MOST_NODES as f64, COARSE_SCALE, COARSER];

/// A pad prepared for touches at any place.
#[derive(Clone, Debug)]
pub(super) struct Scatterer {
    pad: Pad,
    coarse: Level,
    fine: LinearResponses,
    /// Potentials between nodes of the coarse mesh, V/A.
    inverse: Mat<f32>,
}

/// First-order responses of a pad, on the fine mesh.
#[derive(Clone, Debug)]
pub(super) struct LinearResponses {
    level: Level,
    protocol: Protocol,
    /// Channels x triangles: relative change of a reading per relative rise.
    slopes: Mat<f64>,
}

/// One mesh and the solution of the untouched pad.
#[derive(Clone, Debug)]
struct Level {
    model: ForwardModel,
    /// Conductivity of each triangle, S/m.
    background: Vec<f64>,
    fields: Fields,
    volts: Vec<f64>,
    triangles: Buckets,
}

/// Relative changes of all readings for presses at one place that differ in their rise only.
pub(super) struct Changes {
    /// Of the faintest press that raises the conductivity, per rise at its centre.
    pub(super) per_rise: Vec<f64>,
    /// For each rise: of presses that multiply the conductivity by 1 + rise, and of those that divide it.
    pub(super) by_sign: [Vec<Vec<f64>>; 2],
}

impl Scatterer {
    /// The first-order part.
    pub(super) fn linear(&self) -> &LinearResponses {
        &self.fine
    }

    /// Solves a pad's two meshes.
    ///
    /// # Errors
    /// A pad that cannot be solved, or a channel that reads zero.
    pub(super) fn new(pad: &Pad) -> Result<Self, SetupError> {
        let coarse = Level::new(pad, coarse_mesh(pad))?;
        let inverse = coarse.model.dense_inverse(&coarse.background)?;
        Ok(Self {
            pad: pad.clone(),
            coarse,
            fine: LinearResponses::new(pad)?,
            inverse,
        })
    }

    /// Relative changes of all readings for presses that differ in their rise only.
    #[must_use]
    pub(super) fn changes(&self, centre_mm: PointMm, radius_mm: f64, rises: &[f64]) -> Changes {
        let press = Press {
            centre_mm,
            radius_mm,
            rise: 1.0,
        };
        let fine = self.fine.per_rise(centre_mm, radius_mm);
        let local = Local::new(self, &press);
        let coarse = {
            let change = local.stiffness_change(|share| share);
            self.relative(&local, &change, &local.fields)
        };
        // The two meshes differ in amplitude as well as in shape.
        let scale = (norm(&fine) / norm(&coarse).max(f64::MIN_POSITIVE)).min(2.0);
        let by_sign = [TouchSign::Rise, TouchSign::Fall].map(|sign| {
            let solved = rises.iter().map(|rise| {
                let change = local.stiffness_change(|share| Press::change_of(rise * share, sign));
                let exact = self.relative(&local, &change, &local.touched_fields(&change));
                let rise = f64::from(sign.factor()) * rise;
                fine.iter()
                    .zip(coarse.iter().zip(&exact))
                    .map(|(fine, (first, exact))| rise * fine + scale * (exact - rise * first))
                    .collect()
            });
            solved.collect()
        });
        Changes {
            per_rise: fine,
            by_sign,
        }
    }

    /// Relative changes of the readings from the change of the stiffness between joined nodes and the fields of the touched pad.
    fn relative(&self, local: &Local, change: &[f64], touched: &Mat<f64>) -> Vec<f64> {
        let fields = self.coarse.fields.len();
        let mut weighted = Mat::<f64>::zeros(local.nodes, fields);
        for ([row, column], siemens) in local.joined.iter().zip(change) {
            for field in 0..fields {
                weighted[(*row, field)] += siemens * touched[(*column, field)];
            }
        }
        let sums = local.fields.transpose() * &weighted;
        pair_sums(&self.pad.protocol, fields, |k, l| sums[(k, l)])
            .zip(&self.coarse.volts)
            .map(|(change, volt)| change / volt)
            .collect()
    }
}

impl LinearResponses {
    /// Solves a pad.
    ///
    /// # Errors
    /// A pad that cannot be solved, or a channel that reads zero.
    pub(super) fn new(pad: &Pad) -> Result<Self, SetupError> {
        let level = Level::new(pad, Mesh::from_pad(pad, MeshSize::reconstruction(pad)))?;
        let all: Vec<usize> = (0..level.model.mesh().triangles.len()).collect();
        let mut slopes = element_jacobian(&level.model, &level.fields, &pad.protocol, &all);
        for triangle in 0..slopes.ncols() {
            for (entry, volt) in slopes.col_mut(triangle).iter_mut().zip(&level.volts) {
                *entry *= level.background[triangle] / volt;
            }
        }
        Ok(Self {
            level,
            protocol: pad.protocol.clone(),
            slopes,
        })
    }

    /// First-order relative changes of all readings per relative rise at the centre of a press.
    pub(super) fn per_rise(&self, centre_mm: PointMm, radius_mm: f64) -> Vec<f64> {
        let press = Press {
            centre_mm,
            radius_mm,
            rise: 1.0,
        };
        let mut sum = vec![0.0; self.level.volts.len()];
        let mesh = self.level.model.mesh();
        for triangle in self.level.triangles.near(centre_mm, radius_mm) {
            let change = mean_of(mesh, triangle, |point| press.rise_share(point));
            if change == 0.0 {
                continue;
            }
            let gains = self.slopes.col(triangle);
            for (total, gain) in sum.iter_mut().zip(gains.iter()) {
                *total += change * gain;
            }
        }
        sum
    }

    /// First-order relative changes of all readings for a conductivity that rises along an axis and falls as much across it, per
    /// relative rise at the centre of a press: for the axes along x and along the diagonal.
    pub(super) fn per_stretch(&self, centre_mm: PointMm, radius_mm: f64) -> [Vec<f64>; 2] {
        let press = Press {
            centre_mm,
            radius_mm,
            rise: 1.0,
        };
        let Level {
            model,
            fields,
            background,
            volts,
            triangles,
        } = &self.level;
        let count = fields.len();
        let mut sums = [(); 2].map(|()| vec![0.0; count * count]);
        let (mut x, mut y) = (vec![0.0; count], vec![0.0; count]);
        for triangle in triangles.near(centre_mm, radius_mm) {
            let share = mean_of(model.mesh(), triangle, |point| press.rise_share(point));
            if share == 0.0 {
                continue;
            }
            let weight = share * background[triangle] * model.weight(triangle);
            model.gradients(fields, triangle, &mut x, &mut y);
            // Both are symmetric.
            for k in 0..count {
                for l in k..count {
                    sums[0][k * count + l] += weight * (x[k] * x[l] - y[k] * y[l]);
                    sums[1][k * count + l] += weight * (x[k] * y[l] + y[k] * x[l]);
                }
            }
        }
        sums.map(|sums| {
            let changes = pair_sums(&self.protocol, count, |k, l| {
                sums[k.min(l) * count + k.max(l)]
            });
            changes
                .zip(volts)
                .map(|(change, volt)| change / volt)
                .collect()
        })
    }
}

/// The part of the coarse mesh under presses that differ in their rise only.
struct Local {
    nodes: usize,
    under: Vec<Under>,
    /// Pairs of nodes that share a triangle: row and column among the local nodes, by column.
    joined: Vec<[usize; 2]>,
    /// Potentials between the nodes, V/A.
    inverse: Mat<f64>,
    /// Nodes x fields of the untouched pad, V/A.
    fields: Mat<f64>,
}

/// A triangle under a press.
struct Under {
    /// Shares of the press's rise at the triangle's sixteen points.
    shares: [f64; 16],
    /// For each pair of corners, the place in [`Local::joined`], and the stiffness between them, S.
    stiffness: [(usize, f64); 9],
}

impl Local {
    fn new(scatterer: &Scatterer, press: &Press) -> Self {
        let Scatterer {
            coarse, inverse, ..
        } = scatterer;
        let mesh = coarse.model.mesh();
        let near = coarse.triangles.near(press.centre_mm, press.radius_mm);
        let under: Vec<(usize, [f64; 16])> = near
            .into_iter()
            .map(|triangle| {
                let points = mesh.sixteenth_points_mm(triangle);
                (triangle, points.map(|point| press.rise_share(point)))
            })
            .filter(|(_, shares)| shares.iter().any(|share| *share > 0.0))
            .collect();
        let mut nodes: Vec<usize> = under
            .iter()
            .flat_map(|(triangle, _)| mesh.triangles[*triangle])
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |node: usize| nodes.partition_point(|other| *other < node);
        let corners = |triangle: usize| mesh.triangles[triangle].map(place);
        let mut joined: Vec<[usize; 2]> = under
            .iter()
            .flat_map(|(triangle, _)| pairs(corners(*triangle)))
            .collect();
        joined.sort_unstable_by_key(|[row, column]| (*column, *row));
        joined.dedup();
        let count = nodes.len();
        let under = under
            .into_iter()
            .map(|(triangle, shares)| {
                let element = coarse.model.element(triangle);
                let corners = corners(triangle);
                let stiffness = pairs([0, 1, 2]).map(|[i, j]| {
                    let at = joined.partition_point(|[row, column]| {
                        (*column, *row) < (corners[j], corners[i])
                    });
                    (at, coarse.background[triangle] * element.stiffness(i, j))
                });
                Under { shares, stiffness }
            })
            .collect();
        Self {
            nodes: count,
            under,
            joined,
            inverse: Mat::from_fn(count, count, |i, j| {
                f64::from(inverse[(nodes[i], nodes[j])])
            }),
            fields: Mat::from_fn(count, coarse.fields.len(), |i, field| {
                coarse.fields.at_node(nodes[i], field)
            }),
        }
    }

    /// Changes of the stiffness between joined nodes, S, for the relative change of conductivity at a share of the rise.
    fn stiffness_change(&self, change: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut siemens = vec![0.0; self.joined.len()];
        for Under { shares, stiffness } in &self.under {
            let mean = shares.map(&change).iter().sum::<f64>() / 16.0;
            for (at, stiffness) in stiffness {
                siemens[*at] += mean * stiffness;
            }
        }
        siemens
    }

    /// The fields of the touched pad.
    fn touched_fields(&self, change: &[f64]) -> Mat<f64> {
        let mut system = Mat::<f64>::identity(self.nodes, self.nodes);
        for ([row, column], siemens) in self.joined.iter().zip(change) {
            let from = self.inverse.col(*row);
            let to = system.col_mut(*column);
            for (sum, value) in to.iter_mut().zip(from.iter()) {
                *sum += siemens * value;
            }
        }
        system.partial_piv_lu().solve(&self.fields)
    }
}

/// All pairs of three corners, each with itself, too.
fn pairs(corners: [usize; 3]) -> [[usize; 2]; 9] {
    std::array::from_fn(|index| [corners[index / 3], corners[index % 3]])
}

impl Level {
    fn new(pad: &Pad, mesh: Mesh) -> Result<Self, SetupError> {
        let triangles = Buckets::new(&mesh);
        let model = ForwardModel::new(mesh, &ContactModel::from_pad(pad))?;
        let background = model.mesh().background_s_per_m(pad);
        let fields = model.solve(&background)?;
        let volts = fields.voltages(&pad.protocol);
        if let Some(channel) = crate::eit::reconstruct::dead_channel(&volts) {
            return Err(SetupError::DeadChannel { channel });
        }
        Ok(Self {
            model,
            background,
            fields,
            volts,
            triangles,
        })
    }
}

/// The finest mesh with at most [`MOST_NODES`] nodes.
fn coarse_mesh(pad: &Pad) -> Mesh {
    let mut scale = COARSE_SCALE;
    loop {
        let mesh = Mesh::from_pad(pad, MeshSize::relative(pad, scale, false));
        if mesh.nodes_mm.len() <= MOST_NODES || scale > 100.0 {
            return mesh;
        }
        scale *= COARSER;
    }
}

/// Mean over a triangle, sampled at sixteen points.
fn mean_of(mesh: &Mesh, triangle: usize, f: impl Fn(PointMm) -> f64) -> f64 {
    mesh.sixteenth_points_mm(triangle)
        .into_iter()
        .map(f)
        .sum::<f64>()
        / 16.0
}

fn norm(values: &[f64]) -> f64 {
    libm::sqrt(values.iter().map(|value| value * value).sum())
}

/// Triangles by the grid cell that contains their centroid.
#[derive(Clone, Debug)]
struct Buckets {
    cell_mm: f64,
    columns: usize,
    cells: Vec<Vec<usize>>,
    /// Largest distance of a corner from its centroid, mm.
    reach_mm: f64,
    centres_mm: Vec<PointMm>,
}

impl Buckets {
    fn new(mesh: &Mesh) -> Self {
        let far = mesh.nodes_mm.iter().fold([0.0f64; 2], |far, node| {
            [far[0].max(node[0]), far[1].max(node[1])]
        });
        let cell_mm = (far[0].max(far[1]) / 40.0).max(1e-6);
        let [columns, rows] = far.map(|side| (side / cell_mm) as usize + 1);
        let centres_mm: Vec<PointMm> = (0..mesh.triangles.len())
            .map(|triangle| mesh.centroid_mm(triangle))
            .collect();
        let mut cells = vec![Vec::new(); columns * rows];
        let mut reach_mm = 0.0f64;
        for (triangle, [x, y]) in centres_mm.iter().copied().enumerate() {
            cells[(y / cell_mm) as usize * columns + (x / cell_mm) as usize].push(triangle);
            for corner in mesh.corners_mm(triangle) {
                reach_mm = reach_mm.max(libm::hypot(corner[0] - x, corner[1] - y));
            }
        }
        Self {
            cell_mm,
            columns,
            cells,
            reach_mm,
            centres_mm,
        }
    }

    /// Triangles that may overlap a circle, ascending.
    fn near(&self, [x, y]: PointMm, radius_mm: f64) -> Vec<usize> {
        let reach = radius_mm + self.reach_mm;
        let rows = self.cells.len() / self.columns;
        let span = |middle: f64, count: usize| {
            let first = ((middle - reach) / self.cell_mm).max(0.0) as usize;
            let last = ((middle + reach) / self.cell_mm).max(0.0) as usize;
            first.min(count)..(last + 1).min(count)
        };
        let mut near: Vec<usize> = span(y, rows)
            .flat_map(|row| span(x, self.columns).map(move |column| row * self.columns + column))
            .flat_map(|cell| self.cells[cell].iter().copied())
            .filter(|triangle| {
                let [cx, cy] = self.centres_mm[*triangle];
                libm::hypot(cx - x, cy - y) < reach
            })
            .collect();
        near.sort_unstable();
        near
    }
}
