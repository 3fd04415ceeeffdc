//! Hexahedra on a grid, any of them left out, and their trilinear shape functions.
//!
//! Nodes are numbered in the order of elimination, so that systems assembled on them need no reordering.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::order::nested_dissection;

/// A point, mm.
pub type Point = [f64; 3];

/// Corners of a brick. Bit 0 of a corner's number is set at the far end along x, bit 1 along y, bit 2 along z.
pub const CORNERS: usize = 8;

/// A vector for each corner of a brick, as columns: places, displacements or gradients.
pub type Corners = SMatrix<f64, 3, CORNERS>;

/// Grid lines along x, y and z, mm, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines(pub [Vec<f64>; 3]);

impl Lines {
    /// Number of cells along an axis.
    #[must_use]
    pub fn cells(&self, axis: usize) -> usize {
        self.0[axis].len() - 1
    }

    /// The centre of a cell, mm.
    #[must_use]
    pub fn middle_mm(&self, cell: [usize; 3]) -> Point {
        std::array::from_fn(|axis| {
            let lines = &self.0[axis];
            f64::midpoint(lines[cell[axis]], lines[cell[axis] + 1])
        })
    }

    /// The share of a cell's plan (x, y) for which `holds`, by `side` x `side` points.
    #[must_use]
    pub fn share_of_plan(
        &self,
        cell: [usize; 3],
        side: usize,
        holds: impl Fn([f64; 2]) -> bool,
    ) -> f64 {
        let at = |axis: usize, step: usize| {
            let lines = &self.0[axis][cell[axis]..];
            lines[0] + (lines[1] - lines[0]) * (step as f64 + 0.5) / side as f64
        };
        let points = (0..side * side).map(|point| [at(0, point % side), at(1, point / side)]);
        points.filter(|point| holds(*point)).count() as f64 / (side * side) as f64
    }

    /// The cell that contains a point, and the point's place in it (0 to 1 along each axis). A point off the grid is moved
    /// to its edge.
    #[must_use]
    pub fn locate(&self, point_mm: Point) -> ([usize; 3], [f64; 3]) {
        let mut cell = [0; 3];
        let mut share = [0.0; 3];
        for axis in 0..3 {
            let lines = &self.0[axis];
            let after = lines.partition_point(|line| *line <= point_mm[axis]);
            cell[axis] = after.clamp(1, lines.len() - 1) - 1;
            let (low, high) = (lines[cell[axis]], lines[cell[axis] + 1]);
            share[axis] = ((point_mm[axis] - low) / (high - low)).clamp(0.0, 1.0);
        }
        (cell, share)
    }
}

/// The bricks of a body, with x running fastest, then y, then z.
#[derive(Clone, Debug)]
pub struct Bricks {
    lines: Lines,
    /// Place of each node, mm.
    pub nodes_mm: Vec<Point>,
    /// Grid indices of each node.
    pub at: Vec<[u32; 3]>,
    /// Corner nodes of each brick.
    pub corners: Vec<[u32; CORNERS]>,
    /// Grid cell of each brick.
    pub cells: Vec<[usize; 3]>,
    /// The node at each grid index, x fastest; `u32::MAX` where there is none.
    node_at: Vec<u32>,
}

impl Bricks {
    /// A brick for each cell of a grid for which `filled` holds.
    #[must_use]
    pub fn new(lines: Lines, filled: impl Fn([usize; 3]) -> bool) -> Self {
        let counts: [usize; 3] = std::array::from_fn(|axis| lines.0[axis].len());
        let flat = |at: [usize; 3]| (at[2] * counts[1] + at[1]) * counts[0] + at[0];
        let cells: Vec<[usize; 3]> = indices([0, 1, 2].map(|axis| lines.cells(axis)))
            .filter(|cell| filled(*cell))
            .collect();
        let mut used = vec![false; counts.iter().product()];
        for cell in &cells {
            for corner in 0..CORNERS {
                used[flat(corner_of(*cell, corner))] = true;
            }
        }
        let places: Vec<[usize; 3]> = indices(counts).filter(|at| used[flat(*at)]).collect();
        let at: Vec<[u32; 3]> = places.iter().map(|at| at.map(|line| line as u32)).collect();
        let order = nested_dissection(&at);
        let mut node_at = vec![u32::MAX; used.len()];
        for (node, place) in order.iter().enumerate() {
            node_at[flat(places[*place])] = node as u32;
        }
        let nodes_mm = order
            .iter()
            .map(|place| std::array::from_fn(|axis| lines.0[axis][places[*place][axis]]))
            .collect();
        let corners = cells
            .iter()
            .map(|cell| std::array::from_fn(|corner| node_at[flat(corner_of(*cell, corner))]))
            .collect();
        Self {
            nodes_mm,
            at: order.iter().map(|place| at[*place]).collect(),
            corners,
            cells,
            node_at,
            lines,
        }
    }

    /// The grid's lines.
    #[must_use]
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// The node at a grid index.
    #[must_use]
    pub fn node(&self, at: [usize; 3]) -> Option<usize> {
        let counts: [usize; 2] = std::array::from_fn(|axis| self.lines.0[axis].len());
        let node = self.node_at[(at[2] * counts[1] + at[1]) * counts[0] + at[0]];
        (node != u32::MAX).then_some(node as usize)
    }

    /// Interpolates a vector that is given at each node, trilinearly; `None` where the cell lacks a node.
    #[must_use]
    pub fn interpolate(&self, values: &[Point], point_mm: Point) -> Option<Point> {
        let (cell, share) = self.lines.locate(point_mm);
        let mut sum = Vector3::zeros();
        for corner in 0..CORNERS {
            let value = values[self.node(corner_of(cell, corner))?];
            let weights = [0, 1, 2].map(|axis| corner_weight(corner, axis, share[axis]));
            sum += weights.iter().product::<f64>() * Vector3::from(value);
        }
        Some(sum.into())
    }

    /// The brick that contains a point, and the number of its nearest Gauss point.
    #[must_use]
    pub fn nearest(&self, point_mm: Point) -> Option<(usize, usize)> {
        let (cell, share) = self.lines.locate(point_mm);
        let rank = |cell: &[usize; 3]| [cell[2], cell[1], cell[0]];
        let brick = self.cells.binary_search_by_key(&rank(&cell), rank).ok()?;
        let point = (0..3).map(|axis| usize::from(share[axis] > 0.5) << axis);
        Some((brick, point.sum()))
    }

    /// The values of all nodes at the corners of a brick.
    #[must_use]
    pub fn corners_of(&self, brick: usize, values: &[Point]) -> Corners {
        let columns = self.corners[brick].map(|node| Vector3::from(values[node as usize]));
        Corners::from_columns(&columns)
    }
}

/// All index triples below `counts`, x fastest.
fn indices(counts: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let [columns, rows, layers] = counts;
    (0..columns * rows * layers).map(move |index| {
        let rest = index / columns;
        [index % columns, rest % rows, rest / rows]
    })
}

fn corner_of(cell: [usize; 3], corner: usize) -> [usize; 3] {
    std::array::from_fn(|axis| cell[axis] + (corner >> axis & 1))
}

/// Value along one axis of a corner's shape function: 1 at the corner, 0 at the opposite side.
fn corner_weight(corner: usize, axis: usize, share: f64) -> f64 {
    if corner >> axis & 1 == 0 {
        1.0 - share
    } else {
        share
    }
}

/// One point of Gauss' rule in a brick.
#[derive(Clone, Copy, Debug)]
pub struct GaussPoint {
    /// Gradient of each corner's shape function, 1/mm.
    pub gradients: Corners,
    /// Volume for which the point stands, mm3; negative if the brick is turned inside out there.
    pub volume_mm3: f64,
}

/// Positions of the points of Gauss' rule along an edge, as shares of its length.
pub(super) const GAUSS_SHARES: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// The 2 x 2 x 2 rule in a brick with these corners, mm.
#[must_use]
pub fn gauss_points(corners_mm: &Corners) -> [GaussPoint; 8] {
    std::array::from_fn(|point| {
        let local = Corners::from_fn(|axis, corner| {
            let weight = |axis| corner_weight(corner, axis, GAUSS_SHARES[point >> axis & 1]);
            let slope = if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            slope * weight((axis + 1) % 3) * weight((axis + 2) % 3)
        });
        let jacobian: Matrix3<f64> = corners_mm * local.transpose();
        let inverse = jacobian.try_inverse().unwrap_or_else(Matrix3::zeros);
        GaussPoint {
            gradients: inverse.tr_mul(&local),
            volume_mm3: jacobian.determinant() / 8.0,
        }
    })
}

/// Grid lines between two ends: `step_mm` apart within `even_mm` of a place, then each step `growth` times the one before,
/// up to `most_mm`. The place lies in the middle of a cell.
#[must_use]
pub fn growing_lines(
    [from, to]: [f64; 2],
    place: f64,
    even_mm: f64,
    [step_mm, most_mm]: [f64; 2],
    growth: f64,
) -> Vec<f64> {
    let half = |length: f64| -> Vec<f64> {
        let mut lines = vec![step_mm / 2.0];
        let mut step = step_mm;
        loop {
            let last = lines[lines.len() - 1];
            if last >= even_mm {
                step = (step * growth).min(most_mm);
            }
            // The last cell takes the rest: up to 1.5 steps.
            if last + 1.5 * step >= length {
                lines.push(length);
                return lines;
            }
            lines.push(last + step);
        }
    };
    let below = half(place - from).into_iter().rev().map(|off| place - off);
    let beyond = half(to - place).into_iter().map(|off| place + off);
    below.chain(beyond).collect()
}
