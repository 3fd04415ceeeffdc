//! Bricks on a grid of lines, some of them left out, and their shape functions.
//!
//! Nodes are numbered in the order of elimination, so that systems made on them need no order of their own.

use super::order::nested_dissection;

/// A point, mm.
pub type Point = [f64; 3];

/// The corner of a brick with number c lies at its far end along x if c is odd, along y if c / 2 is odd, along z if c / 4 is.
pub const CORNERS: usize = 8;

/// Lines of a grid along x, y and z, mm, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines(pub [Vec<f64>; 3]);

impl Lines {
    /// Cells along an axis.
    #[must_use]
    pub fn cells(&self, axis: usize) -> usize {
        self.0[axis].len() - 1
    }

    /// The middle of a cell, mm.
    #[must_use]
    pub fn middle_mm(&self, cell: [usize; 3]) -> Point {
        std::array::from_fn(|axis| {
            let lines = &self.0[axis];
            f64::midpoint(lines[cell[axis]], lines[cell[axis] + 1])
        })
    }

    /// The cell in which a point lies, and where in it (0 to 1 along each axis). Points off the grid are taken to its edge.
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

/// The bricks of a body.
#[derive(Clone, Debug)]
pub struct Bricks {
    lines: Lines,
    /// Nodes, mm.
    pub nodes_mm: Vec<Point>,
    /// Each node's lines.
    pub at: Vec<[u32; 3]>,
    /// Each brick's corners.
    pub corners: Vec<[u32; CORNERS]>,
    /// Each brick's cell.
    pub cells: Vec<[usize; 3]>,
    /// The node where three lines meet, `u32::MAX` if none: x runs fastest.
    node_at: Vec<u32>,
}

impl Bricks {
    /// The cells of a grid for which `filled` holds.
    #[must_use]
    pub fn new(lines: Lines, filled: impl Fn([usize; 3]) -> bool) -> Self {
        let counts: [usize; 3] = std::array::from_fn(|axis| lines.0[axis].len());
        let flat = |at: [usize; 3]| (at[2] * counts[1] + at[1]) * counts[0] + at[0];
        let mut cells = Vec::new();
        let mut used = vec![false; counts.iter().product()];
        for k in 0..lines.cells(2) {
            for j in 0..lines.cells(1) {
                for i in 0..lines.cells(0) {
                    if filled([i, j, k]) {
                        cells.push([i, j, k]);
                        for corner in 0..CORNERS {
                            used[flat(corner_of([i, j, k], corner))] = true;
                        }
                    }
                }
            }
        }
        let meeting = |index: usize| {
            let (i, rest) = (index % counts[0], index / counts[0]);
            [i, rest % counts[1], rest / counts[1]]
        };
        let places: Vec<[usize; 3]> = (0..used.len())
            .filter(|index| used[*index])
            .map(meeting)
            .collect();
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

    /// The lines of the grid.
    #[must_use]
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// The node where three lines meet.
    #[must_use]
    pub fn node(&self, at: [usize; 3]) -> Option<usize> {
        let counts: [usize; 2] = std::array::from_fn(|axis| self.lines.0[axis].len());
        let node = self.node_at[(at[2] * counts[1] + at[1]) * counts[0] + at[0]];
        (node != u32::MAX).then_some(node as usize)
    }

    /// A value of each node at a point, trilinear in its cell; nothing where the cell lacks a node.
    #[must_use]
    pub fn interpolate(&self, values: &[Point], point_mm: Point) -> Option<Point> {
        let (cell, share) = self.lines.locate(point_mm);
        let mut sum = [0.0; 3];
        for corner in 0..CORNERS {
            let value = values[self.node(corner_of(cell, corner))?];
            let weight: f64 = (0..3)
                .map(|axis| match corner >> axis & 1 {
                    0 => 1.0 - share[axis],
                    _ => share[axis],
                })
                .product();
            for (sum, value) in sum.iter_mut().zip(value) {
                *sum += weight * value;
            }
        }
        Some(sum)
    }

    /// The brick in which a point lies, and which of its Gauss points is the nearest; nothing where there is none.
    #[must_use]
    pub fn nearest(&self, point_mm: Point) -> Option<(usize, usize)> {
        let (cell, share) = self.lines.locate(point_mm);
        // Cells are listed with x running fastest, then y, then z.
        let rank = |cell: &[usize; 3]| [cell[2], cell[1], cell[0]];
        let brick = self.cells.binary_search_by_key(&rank(&cell), rank).ok()?;
        let point = (0..3).map(|axis| usize::from(share[axis] > 0.5) << axis);
        Some((brick, point.sum()))
    }

    /// The corners of a brick, from places of all nodes.
    #[must_use]
    pub fn corners_of(&self, brick: usize, places: &[Point]) -> [Point; CORNERS] {
        self.corners[brick].map(|node| places[node as usize])
    }
}

fn corner_of(cell: [usize; 3], corner: usize) -> [usize; 3] {
    std::array::from_fn(|axis| cell[axis] + (corner >> axis & 1))
}

/// One point of Gauss' rule in a brick: gradients of the shape functions (1/mm) and the volume it stands for (mm3).
#[derive(Clone, Copy, Debug)]
pub struct GaussPoint {
    /// One a corner.
    pub gradients: [Point; CORNERS],
    /// Negative if the brick is turned inside out there.
    pub volume_mm3: f64,
}

/// Where along an edge the points of Gauss' rule lie, as shares of its length.
pub(super) const GAUSS_SHARES: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// The 2 x 2 x 2 rule in a brick with these corners.
#[must_use]
pub fn gauss_points(corners_mm: &[Point; CORNERS]) -> [GaussPoint; 8] {
    std::array::from_fn(|point| {
        let place: Point = std::array::from_fn(|axis| GAUSS_SHARES[point >> axis & 1]);
        let local: [Point; CORNERS] = std::array::from_fn(|corner| {
            let factor = |axis: usize| match corner >> axis & 1 {
                0 => 1.0 - place[axis],
                _ => place[axis],
            };
            let slope = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            [
                slope(0) * factor(1) * factor(2),
                factor(0) * slope(1) * factor(2),
                factor(0) * factor(1) * slope(2),
            ]
        });
        let mut jacobian = [[0.0; 3]; 3];
        for (corner, slope) in corners_mm.iter().zip(&local) {
            for row in 0..3 {
                for column in 0..3 {
                    jacobian[row][column] += corner[row] * slope[column];
                }
            }
        }
        let (inverse, determinant) = inverted(&jacobian);
        GaussPoint {
            gradients: local.map(|slope| {
                std::array::from_fn(|axis| (0..3).map(|i| inverse[i][axis] * slope[i]).sum())
            }),
            volume_mm3: determinant / 8.0,
        }
    })
}

/// The inverse of a matrix (rows first) and its determinant.
pub(super) fn inverted(m: &[[f64; 3]; 3]) -> ([[f64; 3]; 3], f64) {
    let cofactor = |i: usize, j: usize| {
        let (a, b, c, d) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    let inverse = std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i) / determinant));
    (inverse, determinant)
}

/// Lines from one end to another, `step_mm` apart within `even_mm` of a place, and farther apart the farther from it: each
/// `growth` times the one before, `most_mm` at most. The place lies in the middle of a cell.
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
            // The last cell takes what is left, at most half as long again.
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
