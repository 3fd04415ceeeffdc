//! The mechanics of one brick of rubber at large deformation: energy, forces, stiffness.
//!
//! Neo-Hookean: W = mu/2 (J^(-2/3) tr F'F - 3) + kappa/2 (v/V - 1)^2, with the change of volume v/V taken over the whole brick
//! (mean dilatation), so that a brick of nearly incompressible rubber does not lock: Simo, Taylor, Pister, Comput. Methods
//! Appl. Mech. Eng. 51 (1985), 177-208. Forces are the exact gradient of the energy and the stiffness its exact second
//! derivative. So the stiffness is symmetric, and Newton's method converges quadratically.

use nalgebra::{Matrix3, SMatrix, SVector};

use super::bricks::{CORNERS, Corners, GaussPoint};

/// Degrees of freedom of a brick.
pub(super) const DOFS: usize = 3 * CORNERS;

/// A value for each degree of freedom: corner by corner, x, y, z.
pub(super) type DofVector = SVector<f64, DOFS>;

/// A deformation gradient dx/dX.
pub type Gradient = Matrix3<f64>;

/// A rubber-like solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rubber {
    /// Shear modulus, kPa.
    pub shear_kpa: f64,
    /// Bulk modulus, kPa.
    pub bulk_kpa: f64,
}

impl Rubber {
    /// From Young's modulus (kPa) and Poisson's ratio at small strains.
    #[must_use]
    pub fn from_young(young_kpa: f64, poisson: f64) -> Self {
        Self {
            shear_kpa: young_kpa / (2.0 * (1.0 + poisson)),
            bulk_kpa: young_kpa / (3.0 * (1.0 - 2.0 * poisson)),
        }
    }

    /// The material of a brick of which a `share` is another solid: the mean of the stiffnesses (Voigt).
    #[must_use]
    pub fn mixed(self, other: Self, share: f64) -> Self {
        let mean = |a: f64, b: f64| (1.0 - share) * a + share * b;
        Self {
            shear_kpa: mean(self.shear_kpa, other.shear_kpa),
            bulk_kpa: mean(self.bulk_kpa, other.bulk_kpa),
        }
    }
}

/// Forces and stiffness of a brick under displacements of its corners.
pub(super) struct Response {
    /// Forces on the corners, mN.
    pub forces: DofVector,
    /// Their derivatives, mN/mm; symmetric.
    pub stiffness: SMatrix<f64, DOFS, DOFS>,
    /// Pressure, kPa; positive under tension.
    pub pressure_kpa: f64,
    /// Its derivative, kPa/mm.
    pub pressure_slope: DofVector,
}

/// The deformation at one Gauss point.
struct Strain<'a> {
    point: &'a GaussPoint,
    /// Deformation gradient F, and its determinant J.
    f: Gradient,
    swell: f64,
    /// Gradients of the shape functions in the deformed brick: F^-T times those at rest.
    spatial: Corners,
}

impl<'a> Strain<'a> {
    /// `None` if the brick is turned inside out at the point.
    fn new(point: &'a GaussPoint, moved_mm: &Corners) -> Option<Self> {
        let f = deformation(point, moved_mm);
        let swell = f.determinant();
        if swell <= 0.0 || !swell.is_finite() {
            return None;
        }
        let spatial = f.try_inverse()?.tr_mul(&point.gradients);
        Some(Self {
            point,
            f,
            swell,
            spatial,
        })
    }

    fn deformed_volume(&self) -> f64 {
        self.point.volume_mm3 * self.swell
    }

    /// Adds the forces and the stiffness of the shear energy.
    fn add_shear(&self, shear_kpa: f64, out: &mut Response) {
        let gradients = &self.point.gradients;
        let carried = self.f * gradients;
        let first = self.f.norm_squared();
        let scale = self.point.volume_mm3 * shear_kpa / libm::cbrt(self.swell * self.swell);
        out.forces += scale * flat(&(carried - first / 3.0 * self.spatial));
        let dots = gradients.tr_mul(gradients);
        add_blocks(&mut out.stiffness, |a, b| {
            let (spatial_a, spatial_b) = (self.spatial.column(a), self.spatial.column(b));
            let mixed = carried.column(a) * spatial_b.transpose()
                + spatial_a * carried.column(b).transpose();
            let outer = spatial_a * spatial_b.transpose();
            scale
                * (Matrix3::from_diagonal_element(dots[(a, b)]) - 2.0 / 3.0 * mixed
                    + 2.0 / 9.0 * first * outer
                    + first / 3.0 * outer.transpose())
        });
    }

    /// Adds `pressure_kpa` times the second derivative of the deformed volume.
    fn add_pressure(&self, pressure_kpa: f64, out: &mut Response) {
        let scale = pressure_kpa * self.deformed_volume();
        add_blocks(&mut out.stiffness, |a, b| {
            let outer = self.spatial.column(a) * self.spatial.column(b).transpose();
            scale * (outer - outer.transpose())
        });
    }
}

/// Forces and stiffness of a brick; `None` if it is turned inside out.
///
/// With `predicted_kpa` the stiffness is that of a brick under this pressure. During Newton's iterations the pressure
/// predicted by the last step is a better guess than the one from the volume, which a step of pure rotation changes by the
/// bulk modulus times the step's square. It allows much longer steps (the idea of mixed integration points: Magisano,
/// Leonetti, Garcea, 2017).
pub(super) fn respond(
    points: &[GaussPoint; 8],
    moved_mm: &Corners,
    rubber: Rubber,
    predicted_kpa: Option<f64>,
) -> Option<Response> {
    let mut out = Response {
        forces: DofVector::zeros(),
        stiffness: SMatrix::zeros(),
        pressure_kpa: 0.0,
        pressure_slope: DofVector::zeros(),
    };
    let mut volume = (0.0, 0.0);
    let mut volume_slope = DofVector::zeros();
    let mut strains = Vec::with_capacity(points.len());
    for point in points {
        let strain = Strain::new(point, moved_mm)?;
        strain.add_shear(rubber.shear_kpa, &mut out);
        volume.0 += point.volume_mm3;
        volume.1 += strain.deformed_volume();
        volume_slope += strain.deformed_volume() * flat(&strain.spatial);
        strains.push(strain);
    }
    let stiffness = rubber.bulk_kpa / volume.0;
    out.pressure_kpa = rubber.bulk_kpa * (volume.1 / volume.0 - 1.0);
    out.pressure_slope = stiffness * volume_slope;
    out.forces += out.pressure_kpa * volume_slope;
    out.stiffness += out.pressure_slope * volume_slope.transpose();
    let pressure_kpa = predicted_kpa.unwrap_or(out.pressure_kpa);
    for strain in &strains {
        strain.add_pressure(pressure_kpa, &mut out);
    }
    Some(out)
}

/// The deformation gradient at a Gauss point of a brick, scaled so that its change of volume is that of the whole brick.
pub(super) fn mean_gradient(
    points: &[GaussPoint; 8],
    moved_mm: &Corners,
    point: usize,
) -> Gradient {
    let swell = |point: &GaussPoint| deformation(point, moved_mm).determinant();
    let at_rest: f64 = points.iter().map(|point| point.volume_mm3).sum();
    let deformed: f64 = points.iter().map(|p| p.volume_mm3 * swell(p)).sum();
    let scale = libm::cbrt(deformed / at_rest / swell(&points[point]));
    scale * deformation(&points[point], moved_mm)
}

/// The deformation gradient F at a Gauss point.
fn deformation(point: &GaussPoint, moved_mm: &Corners) -> Gradient {
    Matrix3::identity() + moved_mm * point.gradients.transpose()
}

/// The columns one below the other.
fn flat(corners: &Corners) -> DofVector {
    DofVector::from_column_slice(corners.as_slice())
}

/// Adds a 3 x 3 block for each pair of corners.
fn add_blocks(
    stiffness: &mut SMatrix<f64, DOFS, DOFS>,
    block: impl Fn(usize, usize) -> Matrix3<f64>,
) {
    for b in 0..CORNERS {
        for a in 0..CORNERS {
            let mut view = stiffness.fixed_view_mut::<3, 3>(3 * a, 3 * b);
            view += block(a, b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::solid::bricks::gauss_points;

    #[test]
    fn the_stiffness_is_the_derivative_of_the_forces() {
        let cube = Corners::from_fn(|axis, corner| {
            f64::from(u8::from(corner >> axis & 1 == 1)) * (1.0 + 0.3 * axis as f64)
                + 0.05 * ((corner * 3 + axis) % 5) as f64
        });
        let moved = Corners::from_fn(|axis, corner| {
            0.1 * (((corner * 7 + axis * 5) % 11) as f64 / 11.0 - 0.5)
        });
        let rubber = Rubber::from_young(60.0, 0.49);
        let points = gauss_points(&cube);
        let there = respond(&points, &moved, rubber, None).expect("sound");
        let step = 1e-6;
        for column in 0..DOFS {
            let shifted = |by: f64| {
                let mut moved = moved;
                moved[column] += by;
                respond(&points, &moved, rubber, None)
                    .expect("sound")
                    .forces
            };
            let (more, less) = (shifted(step), shifted(-step));
            for row in 0..DOFS {
                let slope = (more[row] - less[row]) / (2.0 * step);
                let exact = there.stiffness[(row, column)];
                assert!(
                    (slope - exact).abs() < 1e-3 * rubber.bulk_kpa,
                    "{row} {column}: {slope} {exact}"
                );
            }
        }
    }
}
