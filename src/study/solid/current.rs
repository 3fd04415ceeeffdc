//! The complete electrode model in three dimensions, on bodies at rest or deformed.
//!
//! As `eit::forward` in the plane: the unknowns are the nodes, then all electrodes but the last, which is ground; one field
//! is solved for a unit current into each electrode. Somersalo, Cheney, Isaacson, SIAM J. Appl. Math. 52 (1992), (2.2)-(2.6).

use faer::Mat;
use nalgebra::{Vector3, Vector4};

use super::bricks::{Bricks, CORNERS, Corners, GAUSS_SHARES, Point, gauss_points};
use super::rubber::Gradient;
use super::system::{Size, System};
use crate::eit::{ForwardError, combine};
use crate::pad::Protocol;

/// Metres in a millimetre.
const M_PER_MM: f64 = 1e-3;
/// Pairs of a brick's corners.
const PAIRS: usize = CORNERS * (CORNERS + 1) / 2;

/// An electrode: the faces of bricks that it covers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contact {
    /// Corner nodes of each face, in order around it.
    pub faces: Vec<[usize; 4]>,
    /// Contact impedance, ohm m2.
    pub impedance_ohm_m2: f64,
}

/// A conducting body with its electrodes.
#[derive(Debug)]
pub struct CurrentModel {
    bricks: Bricks,
    contacts: Vec<Contact>,
    system: System,
    entries: Vec<[u32; PAIRS]>,
}

/// Potentials of the electrodes for unit currents.
#[derive(Clone, Debug)]
pub struct Transfer {
    /// Electrode by electrode without the last, which is ground, ohm.
    ohm: Mat<f64>,
}

impl CurrentModel {
    /// Finds the structure of the system.
    ///
    /// # Errors
    /// An electrode without a face; more unknowns than fit into memory.
    pub fn new(bricks: Bricks, contacts: Vec<Contact>) -> Result<Self, ForwardError> {
        if let Some(bare) = contacts.iter().position(|contact| contact.faces.is_empty()) {
            return Err(ForwardError::BareElectrode(bare));
        }
        let nodes = bricks.nodes_mm.len();
        let ground = contacts.len() - 1;
        let faces: Vec<Vec<u32>> = (nodes..)
            .zip(&contacts[..ground])
            .flat_map(|(electrode, contact)| {
                let with_electrode = move |face: &[usize; 4]| {
                    let unknowns = face.iter().chain([&electrode]);
                    unknowns.map(|unknown| *unknown as u32).collect()
                };
                contact.faces.iter().map(with_electrode)
            })
            .collect();
        let groups = bricks
            .corners
            .iter()
            .map(|corners| corners.as_slice())
            .chain(faces.iter().map(Vec::as_slice));
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

    /// Cost of one solve.
    #[must_use]
    pub fn size(&self) -> Size {
        self.system.size()
    }

    /// Solves for nodes at these places and a conductivity of each brick, S/m.
    ///
    /// # Errors
    /// A conductor in separate parts, a brick turned inside out, or too little memory.
    pub fn solve(
        &self,
        places_mm: &[Point],
        conductivity_s_per_m: &[f64],
    ) -> Result<Transfer, ForwardError> {
        let mut values = vec![0.0; self.system.entries()];
        for (brick, (entries, sigma)) in self.entries.iter().zip(conductivity_s_per_m).enumerate() {
            for point in gauss_points(&self.bricks.corners_of(brick, places_mm)) {
                // NaN is not above zero either.
                let is_sound = point.volume_mm3 > 0.0;
                if !is_sound {
                    return Err(ForwardError::InvertedBrick(brick));
                }
                let siemens_mm2 = sigma * point.volume_mm3 * M_PER_MM;
                add_conductance(&mut values, entries, siemens_mm2, &point.gradients);
            }
        }
        self.transfer(places_mm, values)
    }

    /// Solves a deformed body: its nodes lie at `places_mm`, and `gradient_at` is the deformation gradient F at a point of
    /// the body at rest. The system is assembled on the bricks at rest, where a conductivity s of the deformed body acts as
    /// det(F) s F^-1 F^-T. So no brick can turn inside out, however the body folds between its nodes.
    ///
    /// # Errors
    /// A conductor in separate parts, a gradient with a determinant that is not positive, or too little memory.
    pub fn solve_stretched(
        &self,
        places_mm: &[Point],
        gradient_at: impl Fn(Point) -> Gradient,
        conductivity_s_per_m: &[f64],
    ) -> Result<Transfer, ForwardError> {
        let mut values = vec![0.0; self.system.entries()];
        for (brick, (entries, sigma)) in self.entries.iter().zip(conductivity_s_per_m).enumerate() {
            let corners = self.bricks.corners_of(brick, &self.bricks.nodes_mm);
            let (low, high) = (corners.column(0), corners.column(CORNERS - 1));
            for (number, point) in gauss_points(&corners).iter().enumerate() {
                let shares = Vector3::from_fn(|axis, _| GAUSS_SHARES[number >> axis & 1]);
                let place = low + shares.component_mul(&(high - low));
                let gradient = gradient_at(place.into());
                let swell = gradient.determinant();
                let inverse = gradient.try_inverse().filter(|_| swell > 0.0);
                let inverse = inverse.ok_or(ForwardError::InvertedBrick(brick))?;
                let siemens_mm2 = sigma * swell * point.volume_mm3 * M_PER_MM;
                let carried = inverse.tr_mul(&point.gradients);
                add_conductance(&mut values, entries, siemens_mm2, &carried);
            }
        }
        self.transfer(places_mm, values)
    }

    /// Adds the contacts to the bricks' entries, factorises, and solves for 1 A into each electrode but the last, which is
    /// ground: the potentials of the electrodes.
    fn transfer(
        &self,
        places_mm: &[Point],
        mut values: Vec<f64>,
    ) -> Result<Transfer, ForwardError> {
        self.add_contacts(places_mm, &mut values);
        let factor = self.system.factorise(&values)?;
        let nodes = self.bricks.nodes_mm.len();
        let ground = self.contacts.len() - 1;
        let mut fields = Mat::<f64>::zeros(nodes + ground, ground);
        for electrode in 0..ground {
            fields[(nodes + electrode, electrode)] = 1.0;
        }
        factor.solve_in_place(fields.as_mut())?;
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
        let transfer = |into: usize, of: usize| match into == ground || of == ground {
            true => 0.0,
            false => self.ohm(into, of),
        };
        protocol
            .channels
            .iter()
            .map(|channel| combine(channel, transfer))
            .collect()
    }

    /// Potential of electrode `of` for a unit current into electrode `into` and out of the last, ohm.
    #[must_use]
    pub fn ohm(&self, into: usize, of: usize) -> f64 {
        self.ohm[(of, into)]
    }
}

/// Adds the conductance at one Gauss point: conductivity times volume, S mm2, and the gradients of the shape functions, 1/mm.
fn add_conductance(
    values: &mut [f64],
    entries: &[u32; PAIRS],
    siemens_mm2: f64,
    gradients: &Corners,
) {
    for ((i, j), entry) in pairs().zip(entries) {
        values[*entry as usize] += siemens_mm2 * gradients.column(i).dot(&gradients.column(j));
    }
}

/// Pairs of corners, the lower triangle.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..CORNERS).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// Gauss' 2 x 2 rule on a face: the shape functions of its corners, and the area for which each point stands, mm2.
fn face_points(corners_mm: [Point; 4]) -> [(Vector4<f64>, f64); 4] {
    let corners = nalgebra::Matrix3x4::from_columns(&corners_mm.map(Vector3::from));
    let [low, high] = GAUSS_SHARES;
    [(low, low), (high, low), (high, high), (low, high)].map(|(u, v)| {
        let shape = Vector4::new((1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v);
        let along_u = corners * Vector4::new(v - 1.0, 1.0 - v, v, -v);
        let along_v = corners * Vector4::new(u - 1.0, -u, u, 1.0 - u);
        (shape, along_u.cross(&along_v).norm() / 4.0)
    })
}
