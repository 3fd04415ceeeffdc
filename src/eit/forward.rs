//! The forward model: potentials of a sheet with electrodes (complete electrode model).
//!
//! Linear triangles; a sheet of thickness t carries current in its plane only. The unknowns are the nodes, then the
//! electrodes except the last, which is ground: the matrix is symmetric positive definite, and sparse Cholesky (faer)
//! solves for one unit current into each electrode at once. Every stimulation and measurement is a sum of these fields, so
//! one factorisation serves any protocol, and reciprocity holds to rounding.
//!
//! Equations: Somersalo, Cheney, Isaacson, SIAM J. Appl. Math. 52 (1992), (2.2)-(2.6); its finite-element form
//! as in Vauhkonen et al., IEEE Trans. Biomed. Eng. 46 (1999), eq. 10-15.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::LltError;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Mat, Side};

use super::Mesh;
use crate::pad::{Channel, Pad, Protocol};

/// Metres in a millimetre.
const M_PER_MM: f64 = 1e-3;

/// Thickness of the sheet and impedance of its contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactModel {
    /// Thickness of the sheet, m; 1 for two-dimensional units.
    pub thickness_m: f64,
    /// Contact impedance of each electrode, ohm m2.
    pub impedance_ohm_m2: Vec<f64>,
}

impl ContactModel {
    /// The contacts of a pad.
    #[must_use]
    pub fn from_pad(pad: &Pad) -> Self {
        Self {
            thickness_m: pad.thickness_mm * M_PER_MM,
            impedance_ohm_m2: vec![pad.contact_impedance_ohm_m2; pad.electrodes.len()],
        }
    }
}

/// Why a forward model cannot be solved.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ForwardError {
    /// An electrode without an edge of the mesh, counted from 0.
    #[error("electrode {} touches no conductor of the mesh", .0 + 1)]
    BareElectrode(usize),
    /// The matrix is not positive definite.
    #[error(
        "a part of the conductor is connected to no electrode, or a conductivity is not above zero"
    )]
    Disconnected,
    /// The mesh is too large for this machine.
    #[error("the mesh is too large to factorise")]
    TooLarge,
    /// A deformation turns a brick of the body inside out, counted from 0.
    #[error("the deformation turns brick {} inside out", .0 + 1)]
    InvertedBrick(usize),
}

/// A mesh with its contacts, prepared for any conductivity.
#[derive(Clone, Debug)]
pub struct ForwardModel {
    mesh: Mesh,
    /// Lower triangle, by columns.
    pattern: SymbolicSparseColMat<Index>,
    /// The part of each entry that comes from the contacts.
    contact_values: Vec<f64>,
    /// For each triangle, its entries of the matrix, in the order of [`CORNER_PAIRS`].
    entries: Vec<[Index; 6]>,
    thickness_m: f64,
    symbolic: SymbolicLlt<Index>,
}

/// Numbers of unknowns and of entries of the matrix. Meshes stay far below 2^32 of them, and the window keeps a model for its simulated
/// pad, so half the size counts.
type Index = u32;

/// A triangle as the matrix takes it: computed where it is needed, since storing all of them takes megabytes.
pub(super) struct Element {
    /// Gradients of the three shape functions, 1/mm.
    gradients: [[f64; 2]; 3],
    /// Area x thickness, mm2 m: factor of the stiffness.
    weight: f64,
}

impl Element {
    /// Stiffness between two corners (0 to 2) for a unit conductivity, siemens.
    pub(super) fn stiffness(&self, i: usize, j: usize) -> f64 {
        let (gi, gj) = (self.gradients[i], self.gradients[j]);
        self.weight * (gi[0] * gj[0] + gi[1] * gj[1])
    }
}

/// Pairs of a triangle's corners.
const CORNER_PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 0), (2, 1), (2, 0)];

/// Positions of the entries of the stiffness matrix: its lower triangle, by columns.
struct LowerTriangle {
    column_starts: Vec<Index>,
    rows: Vec<Index>,
}

impl LowerTriangle {
    fn new(mesh: &Mesh, contact_terms: &[(usize, usize, f64)]) -> Self {
        let unknowns = mesh.nodes_mm.len() + mesh.electrodes.len() - 1;
        let mut columns: Vec<Vec<Index>> =
            (0..unknowns).map(|column| vec![column as Index]).collect();
        let of_triangles = mesh
            .triangles
            .iter()
            .flat_map(|triangle| CORNER_PAIRS.map(|(i, j)| ordered(triangle[i], triangle[j])));
        let of_contacts = contact_terms.iter().map(|(row, column, _)| (*row, *column));
        for (row, column) in of_triangles.chain(of_contacts) {
            if row != column {
                columns[column].push(row as Index);
            }
        }
        let mut column_starts = vec![0];
        let mut rows = Vec::new();
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
            rows.extend_from_slice(column);
            column_starts.push(rows.len() as Index);
        }
        Self {
            column_starts,
            rows,
        }
    }

    /// Index of the entry between two unknowns.
    fn entry(&self, a: usize, b: usize) -> usize {
        let (row, column) = ordered(a, b);
        let [start, end] = [column, column + 1].map(|at| self.column_starts[at] as usize);
        start + self.rows[start..end].partition_point(|r| (*r as usize) < row)
    }

    fn into_pattern(self) -> SymbolicSparseColMat<Index> {
        let unknowns = self.column_starts.len() - 1;
        SymbolicSparseColMat::new_checked(unknowns, unknowns, self.column_starts, None, self.rows)
    }
}

/// The solution: one field for a unit current into each electrode except the last and out of the last.
#[derive(Clone, Debug)]
pub struct Fields {
    /// Nodes and electrodes x fields, V/A.
    potentials: Mat<f64>,
    nodes: usize,
    electrodes: usize,
}

impl ForwardModel {
    /// Prepares a mesh: assembles the pattern of the matrix and orders the unknowns.
    ///
    /// # Errors
    /// An electrode without an edge of the mesh; a mesh too large for the memory.
    pub fn new(mesh: Mesh, contacts: &ContactModel) -> Result<Self, ForwardError> {
        if let Some(bare) = mesh.electrodes.iter().position(Vec::is_empty) {
            return Err(ForwardError::BareElectrode(bare));
        }
        let terms = contact_terms(&mesh, contacts);
        let lower = LowerTriangle::new(&mesh, &terms);
        let mut contact_values = vec![0.0; lower.rows.len()];
        for (row, column, value) in &terms {
            contact_values[lower.entry(*row, *column)] += value;
        }
        let entries = mesh
            .triangles
            .iter()
            .map(|triangle| {
                CORNER_PAIRS.map(|(i, j)| lower.entry(triangle[i], triangle[j]) as Index)
            })
            .collect();
        let pattern = lower.into_pattern();
        Ok(Self {
            symbolic: SymbolicLlt::try_new(pattern.as_ref(), Side::Lower)
                .map_err(|_| ForwardError::TooLarge)?,
            pattern,
            mesh,
            contact_values,
            entries,
            thickness_m: contacts.thickness_m,
        })
    }

    /// The mesh.
    #[must_use]
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Solves for one conductivity per triangle, S/m.
    ///
    /// # Errors
    /// A matrix that is not positive definite: a conductivity at or below zero, or a part without electrode.
    ///
    /// # Panics
    /// If there is not one conductivity per triangle.
    pub fn solve(&self, conductivity_s_per_m: &[f64]) -> Result<Fields, ForwardError> {
        let factor = self.factorise(conductivity_s_per_m)?;
        let nodes = self.mesh.nodes_mm.len();
        let driven = self.mesh.electrodes.len() - 1;
        let mut potentials = Mat::zeros(nodes + driven, driven);
        for field in 0..driven {
            potentials[(nodes + field, field)] = 1.0;
        }
        factor.solve_in_place(potentials.as_mut());
        Ok(Fields {
            potentials,
            nodes,
            electrodes: driven + 1,
        })
    }

    /// The inverse of the stiffness between nodes, V/A: column j holds the potentials of all nodes for a unit current
    /// into node j. Dense, nodes x nodes, in single precision: for coarse meshes only.
    ///
    /// # Errors
    /// As [`Self::solve`].
    ///
    /// # Panics
    /// As [`Self::solve`].
    pub(super) fn dense_inverse(
        &self,
        conductivity_s_per_m: &[f64],
    ) -> Result<Mat<f32>, ForwardError> {
        /// Right-hand sides solved together: few enough to fit in the caches.
        const BATCH: usize = 32;
        let factor = self.factorise(conductivity_s_per_m)?;
        let nodes = self.mesh.nodes_mm.len();
        let unknowns = nodes + self.mesh.electrodes.len() - 1;
        let mut inverse = Mat::zeros(nodes, nodes);
        for first in (0..nodes).step_by(BATCH) {
            let count = BATCH.min(nodes - first);
            let mut columns = Mat::<f64>::zeros(unknowns, count);
            for column in 0..count {
                columns[(first + column, column)] = 1.0;
            }
            factor.solve_in_place(columns.as_mut());
            for column in 0..count {
                for node in 0..nodes {
                    inverse[(node, first + column)] = columns[(node, column)] as f32;
                }
            }
        }
        Ok(inverse)
    }

    fn factorise(&self, conductivity_s_per_m: &[f64]) -> Result<Llt<Index, f64>, ForwardError> {
        assert_eq!(conductivity_s_per_m.len(), self.entries.len());
        let mut values = self.contact_values.clone();
        let triangles = self.entries.iter().zip(conductivity_s_per_m);
        for (triangle, (entries, sigma)) in triangles.enumerate() {
            let element = self.element(triangle);
            for ((i, j), entry) in CORNER_PAIRS.into_iter().zip(*entries) {
                values[entry as usize] += sigma * element.stiffness(i, j);
            }
        }
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), &values);
        Llt::try_new_with_symbolic(self.symbolic.clone(), matrix, Side::Lower).map_err(|error| {
            match error {
                LltError::Numeric(_) => ForwardError::Disconnected,
                LltError::Generic(_) => ForwardError::TooLarge,
            }
        })
    }

    /// Solves for the same conductivity everywhere, S/m.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_even(&self, conductivity_s_per_m: f64) -> Result<Fields, ForwardError> {
        self.solve(&vec![conductivity_s_per_m; self.entries.len()])
    }

    /// A triangle of the mesh.
    pub(super) fn element(&self, triangle: usize) -> Element {
        Element {
            gradients: shape_gradients(&self.mesh, triangle),
            weight: self.weight(triangle),
        }
    }

    /// Area x thickness of a triangle, mm2 m.
    pub(super) fn weight(&self, triangle: usize) -> f64 {
        self.mesh.area_mm2(triangle) * self.thickness_m
    }

    /// Gradients of all fields in one triangle, V/A/mm: x and y components, one value per field.
    pub(super) fn gradients(&self, fields: &Fields, triangle: usize, x: &mut [f64], y: &mut [f64]) {
        let corners = self.mesh.triangles[triangle];
        let shape = self.element(triangle).gradients;
        for (field, (gx, gy)) in x.iter_mut().zip(y).enumerate() {
            let column = fields.potentials.col(field);
            let u = corners.map(|node| column[node]);
            *gx = u[0] * shape[0][0] + u[1] * shape[1][0] + u[2] * shape[2][0];
            *gy = u[0] * shape[0][1] + u[1] * shape[1][1] + u[2] * shape[2][1];
        }
    }
}

impl Fields {
    /// Number of fields: one less than electrodes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.electrodes - 1
    }

    /// Whether there is no field.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Potential of a node in a field, V/A. The field of the last electrode is zero and not stored.
    pub(super) fn at_node(&self, node: usize, field: usize) -> f64 {
        self.potentials[(node, field)]
    }

    /// Potential of electrode `of` for a unit current into `into` and out of the last electrode, V/A.
    fn transfer(&self, into: usize, of: usize) -> f64 {
        let ground = self.electrodes - 1;
        if into == ground || of == ground {
            0.0
        } else {
            self.potentials[(self.nodes + of, into)]
        }
    }

    /// The reading of one channel, V/A.
    #[must_use]
    pub fn voltage(&self, channel: &Channel) -> f64 {
        combine(channel, |into, of| self.transfer(into, of))
    }

    /// The readings of a protocol, V/A, in its order.
    #[must_use]
    pub fn voltages(&self, protocol: &Protocol) -> Vec<f64> {
        protocol.channels.iter().map(|c| self.voltage(c)).collect()
    }
}

/// A channel's value from a bilinear form of electrodes: drive (a, b), measurement (p, q) reads
/// `f(a, q) - f(a, p) - f(b, q) + f(b, p)`.
pub(crate) fn combine(channel: &Channel, f: impl Fn(usize, usize) -> f64) -> f64 {
    let (drive, measure) = (channel.drive, channel.measure);
    (f(drive.0, measure.1) - f(drive.0, measure.0))
        - (f(drive.1, measure.1) - f(drive.1, measure.0))
}

/// Larger index first: the lower triangle's row and column.
fn ordered(a: usize, b: usize) -> (usize, usize) {
    (a.max(b), a.min(b))
}

fn shape_gradients(mesh: &Mesh, triangle: usize) -> [[f64; 2]; 3] {
    let [a, b, c] = mesh.corners_mm(triangle);
    let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    [(b, c), (c, a), (a, b)].map(|(from, to)| {
        [
            (from[1] - to[1]) / twice_area,
            (to[0] - from[0]) / twice_area,
        ]
    })
}

/// The terms of the contacts: (row, column, siemens) in the lower triangle. For an edge of length l,
/// y = l t / z: y/3 and y/6 between its nodes, -y/2 to the electrode, y on the electrode.
fn contact_terms(mesh: &Mesh, contacts: &ContactModel) -> Vec<(usize, usize, f64)> {
    let nodes = mesh.nodes_mm.len();
    let ground = mesh.electrodes.len() - 1;
    let mut terms = Vec::new();
    for (electrode, edges) in mesh.electrodes.iter().enumerate() {
        for [a, b] in edges.iter().copied() {
            let (pa, pb) = (mesh.nodes_mm[a], mesh.nodes_mm[b]);
            let length_m = libm::hypot(pa[0] - pb[0], pa[1] - pb[1]) * M_PER_MM;
            let y = length_m * contacts.thickness_m / contacts.impedance_ohm_m2[electrode];
            let (row, column) = ordered(a, b);
            terms.extend([(a, a, y / 3.0), (b, b, y / 3.0), (row, column, y / 6.0)]);
            if electrode != ground {
                let unknown = nodes + electrode;
                terms.extend([
                    (unknown, unknown, y),
                    (unknown, a, -y / 2.0),
                    (unknown, b, -y / 2.0),
                ]);
            }
        }
    }
    terms
}
