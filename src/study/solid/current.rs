//! Current in bricks, deformed or not: the complete electrode model in three dimensions.
//!
//! As `eit::forward` does in the plane: nodes first among the unknowns, then the electrodes but the last, which is ground;
//! one field for a unit current into each electrode. Somersalo, Cheney, Isaacson, SIAM J. Appl. Math. 52 (1992), (2.2)-(2.6).

use faer::Mat;

use super::bricks::{Bricks, CORNERS, GAUSS_SHARES, Point, gauss_points, inverted};
use super::rubber::Gradient;
use super::system::{Size, System};
use crate::eit::{ForwardError, combine};
use crate::pad::Protocol;

/// Metres in a millimetre.
const M_PER_MM: f64 = 1e-3;
/// Pairs of a brick's corners.
const PAIRS: usize = CORNERS * (CORNERS + 1) / 2;

/// Where an electrode lies: faces of bricks, their corners in order around each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contact {
    /// Each face's corners.
    pub faces: Vec<[usize; 4]>,
    /// Contact impedance, ohm m2.
    pub impedance_ohm_m2: f64,
}

/// Bricks that conduct, with their electrodes.
#[derive(Debug)]
pub struct CurrentModel {
    bricks: Bricks,
    contacts: Vec<Contact>,
    system: System,
    entries: Vec<[u32; PAIRS]>,
}

/// What unit currents make of the electrodes' potentials.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// Electrode by electrode, the last one ground, ohm.
    ohm: Mat<f64>,
}

impl CurrentModel {
    /// Prepares bricks and their electrodes.
    ///
    /// # Errors
    /// An electrode without a face; more unknowns than fit the memory.
    pub fn new(bricks: Bricks, contacts: Vec<Contact>) -> Result<Self, ForwardError> {
        if let Some(bare) = contacts.iter().position(|contact| contact.faces.is_empty()) {
            return Err(ForwardError::BareElectrode(bare));
        }
        let nodes = bricks.nodes_mm.len();
        let ground = contacts.len() - 1;
        let touching: Vec<Vec<u32>> = contacts[..ground]
            .iter()
            .enumerate()
            .flat_map(|(electrode, contact)| {
                contact.faces.iter().map(move |face| {
                    let mut group: Vec<u32> = face.iter().map(|node| *node as u32).collect();
                    group.push((nodes + electrode) as u32);
                    group
                })
            })
            .collect();
        let groups = bricks
            .corners
            .iter()
            .map(|corners| corners.as_slice())
            .chain(touching.iter().map(Vec::as_slice));
        let system = System::new(nodes + ground, groups).map_err(|_| ForwardError::TooLarge)?;
        let entries = bricks
            .corners
            .iter()
            .map(|corners| {
                let mut pairs = pairs().map(|(i, j)| system.entry(corners[i], corners[j]));
                std::array::from_fn(|_| pairs.next().unwrap_or_default())
            })
            .collect();
        Ok(Self {
            bricks,
            contacts,
            system,
            entries,
        })
    }

    /// The bricks.
    #[must_use]
    pub fn bricks(&self) -> &Bricks {
        &self.bricks
    }

    /// What one solve takes.
    #[must_use]
    pub fn size(&self) -> Size {
        self.system.size()
    }

    /// Solves with nodes at these places and these conductivities of the bricks, S/m.
    ///
    /// # Errors
    /// A conductor that falls apart, a brick turned inside out, or too little memory.
    pub fn solve(
        &self,
        places_mm: &[Point],
        conductivity_s_per_m: &[f64],
    ) -> Result<Transfer, ForwardError> {
        let mut values = vec![0.0; self.system.entries()];
        for (brick, (entries, sigma)) in self.entries.iter().zip(conductivity_s_per_m).enumerate() {
            for point in gauss_points(&self.bricks.corners_of(brick, places_mm)) {
                if point.volume_mm3 <= 0.0 {
                    return Err(ForwardError::Disconnected);
                }
                let siemens_mm2 = sigma * point.volume_mm3 * M_PER_MM;
                conduct(&mut values, entries, siemens_mm2, &point.gradients);
            }
        }
        self.solved(places_mm, values)
    }

    /// Solves a body that is deformed: its nodes lie at these places, and about any point of it at rest it is stretched and
    /// turned by a deformation gradient F. Solved on the bricks at rest, where a conductivity s of the deformed body acts as
    /// det(F) s F^-1 F^-T: so no brick can turn inside out, however the body folds between its nodes.
    ///
    /// # Errors
    /// A conductor that falls apart, a gradient that turns inside out, or too little memory.
    pub fn solve_stretched(
        &self,
        places_mm: &[Point],
        gradient_at: impl Fn(Point) -> Gradient,
        conductivity_s_per_m: &[f64],
    ) -> Result<Transfer, ForwardError> {
        let mut values = vec![0.0; self.system.entries()];
        for (brick, (entries, sigma)) in self.entries.iter().zip(conductivity_s_per_m).enumerate() {
            let corners = self.bricks.corners_of(brick, &self.bricks.nodes_mm);
            let (low, high) = (corners[0], corners[CORNERS - 1]);
            for (number, point) in gauss_points(&corners).iter().enumerate() {
                let place: Point = std::array::from_fn(|axis| {
                    let share = GAUSS_SHARES[number >> axis & 1];
                    low[axis] + share * (high[axis] - low[axis])
                });
                let (inverse, swell) = inverted(&gradient_at(place));
                if swell.is_nan() || swell <= 0.0 {
                    return Err(ForwardError::Disconnected);
                }
                let carried: [Point; CORNERS] = point
                    .gradients
                    .map(|n| std::array::from_fn(|i| (0..3).map(|l| inverse[l][i] * n[l]).sum()));
                let siemens_mm2 = sigma * swell * point.volume_mm3 * M_PER_MM;
                conduct(&mut values, entries, siemens_mm2, &carried);
            }
        }
        self.solved(places_mm, values)
    }

    fn solved(&self, places_mm: &[Point], mut values: Vec<f64>) -> Result<Transfer, ForwardError> {
        self.add_contacts(places_mm, &mut values);
        let factor = self
            .system
            .factorise(&values)
            .map_err(|_| ForwardError::Disconnected)?;
        let nodes = self.bricks.nodes_mm.len();
        let ground = self.contacts.len() - 1;
        let mut fields = Mat::<f64>::zeros(nodes + ground, ground);
        for electrode in 0..ground {
            fields[(nodes + electrode, electrode)] = 1.0;
        }
        factor
            .solve_in_place(fields.as_mut())
            .map_err(|_| ForwardError::TooLarge)?;
        Ok(Transfer {
            ohm: fields.get(nodes.., ..).to_owned(),
        })
    }

    fn add_contacts(&self, places_mm: &[Point], values: &mut [f64]) {
        let nodes = self.bricks.nodes_mm.len();
        let ground = self.contacts.len() - 1;
        for (electrode, contact) in self.contacts.iter().enumerate() {
            for face in &contact.faces {
                for (shape, area_mm2) in face_points(face.map(|node| places_mm[node])) {
                    let y = area_mm2 * M_PER_MM * M_PER_MM / contact.impedance_ohm_m2;
                    let mut add = |a: usize, b: usize, value: f64| {
                        values[self.system.entry(a as u32, b as u32) as usize] += value;
                    };
                    for i in 0..4 {
                        for j in 0..=i {
                            add(face[i], face[j], y * shape[i] * shape[j]);
                        }
                    }
                    if electrode != ground {
                        let unknown = nodes + electrode;
                        add(unknown, unknown, y);
                        for i in 0..4 {
                            add(unknown, face[i], -y * shape[i]);
                        }
                    }
                }
            }
        }
    }
}

impl Transfer {
    /// The readings of a protocol, V/A, in its order.
    #[must_use]
    pub fn voltages(&self, protocol: &Protocol) -> Vec<f64> {
        let ground = self.ohm.ncols();
        let transfer = |into: usize, of: usize| {
            if into == ground || of == ground {
                0.0
            } else {
                self.ohm[(of, into)]
            }
        };
        protocol
            .channels
            .iter()
            .map(|channel| combine(channel, transfer))
            .collect()
    }

    /// Potential of one electrode for a unit current into another and out of the last, ohm.
    #[must_use]
    pub fn ohm(&self, into: usize, of: usize) -> f64 {
        self.ohm[(of, into)]
    }
}

/// Adds what lies about one point of a brick: its conductivity times its volume, S mm^2, and the gradients of its corners' shapes,
/// 1/mm.
fn conduct(
    values: &mut [f64],
    entries: &[u32; PAIRS],
    siemens_mm2: f64,
    gradients: &[Point; CORNERS],
) {
    for ((i, j), entry) in pairs().zip(entries) {
        let (a, b) = (gradients[i], gradients[j]);
        values[*entry as usize] += siemens_mm2 * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
    }
}

/// Pairs of corners, the lower triangle.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..CORNERS).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// Gauss' 2 x 2 rule on a face: the shape functions of its corners, and the area each point stands for.
fn face_points(corners_mm: [Point; 4]) -> [([f64; 4], f64); 4] {
    let half = 0.5 / 3f64.sqrt();
    [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(u, v)| {
        let (u, v) = (0.5 + u, 0.5 + v);
        let shape = [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v];
        let along_u = [-(1.0 - v), 1.0 - v, v, -v];
        let along_v = [-(1.0 - u), -u, u, 1.0 - u];
        let tangent = |slopes: [f64; 4]| -> Point {
            std::array::from_fn(|axis| (0..4).map(|i| slopes[i] * corners_mm[i][axis]).sum())
        };
        let (a, b) = (tangent(along_u), tangent(along_v));
        let cross = [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ];
        let area = (cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]).sqrt();
        (shape, area / 4.0)
    })
}
