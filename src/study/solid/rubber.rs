//! One brick of rubber, stretched as far as one likes: energy, forces, stiffness.
//!
//! Neo-Hookean: W = mu/2 (J^(-2/3) tr F'F - 3) + kappa/2 (v/V - 1)^2, with the change of volume v/V taken over the whole brick
//! (mean dilatation), so that a brick of nearly incompressible rubber does not lock: Simo, Taylor, Pister, Comput. Methods
//! Appl. Mech. Eng. 51 (1985), 177-208. Forces are the energy's gradient and the stiffness is its second derivative, exactly:
//! so it is symmetric, and Newton's method converges quadratically.

use super::bricks::{CORNERS, GaussPoint, Point, inverted};

/// Unknowns of a brick.
pub(super) const DOFS: usize = 3 * CORNERS;

/// A deformation gradient dx/dX, rows first.
pub type Gradient = [[f64; 3]; 3];

/// A rubber-like solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rubber {
    /// Shear modulus, kPa.
    pub shear_kpa: f64,
    /// Bulk modulus, kPa.
    pub bulk_kpa: f64,
}

impl Rubber {
    /// From Young's modulus (kPa) and Poisson's ratio at small strain.
    #[must_use]
    pub fn from_young(young_kpa: f64, poisson: f64) -> Self {
        Self {
            shear_kpa: young_kpa / (2.0 * (1.0 + poisson)),
            bulk_kpa: young_kpa / (3.0 * (1.0 - 2.0 * poisson)),
        }
    }

    /// A brick of two solids, `share` of it the other one: the mean of their stiffnesses (Voigt).
    #[must_use]
    pub fn mixed(self, other: Self, share: f64) -> Self {
        let mean = |a: f64, b: f64| (1.0 - share) * a + share * b;
        Self {
            shear_kpa: mean(self.shear_kpa, other.shear_kpa),
            bulk_kpa: mean(self.bulk_kpa, other.bulk_kpa),
        }
    }
}

/// A brick's answer to its corners' displacements.
pub(super) struct Answer {
    /// Forces of the brick on its corners' displacements, mN.
    pub forces: [f64; DOFS],
    /// Their derivatives, mN/mm, by rows; symmetric.
    pub stiffness: [[f64; DOFS]; DOFS],
    /// Its pressure (tension is above zero), kPa ...
    pub pressure_kpa: f64,
    /// ... and the derivative of that, kPa/mm.
    pub pressure_slope: [f64; DOFS],
}

/// The forces and stiffness of a brick; nothing if it is turned inside out.
///
/// Where a pressure is given, the stiffness is that of a brick under it. While Newton's method is on its way, the pressure
/// that the last step foretold is a better guess than the one of the volume, which a step of rotation alone throws off by
/// the bulk modulus times the step's square: with it steps may be many times longer (the idea of mixed integration points:
/// Magisano, Leonetti, Garcea, 2017).
pub(super) fn answer(
    points: &[GaussPoint; 8],
    moved_mm: &[Point; CORNERS],
    rubber: Rubber,
    foretold_kpa: Option<f64>,
) -> Option<Answer> {
    let mut out = Answer {
        forces: [0.0; DOFS],
        stiffness: [[0.0; DOFS]; DOFS],
        pressure_kpa: 0.0,
        pressure_slope: [0.0; DOFS],
    };
    let mut volume = (0.0, 0.0);
    // First derivative of the deformed volume, and what its second is made of.
    let mut swell = [0.0; DOFS];
    let mut turned = [([[0.0; 3]; CORNERS], 0.0); 8];
    for (point, turned) in points.iter().zip(&mut turned) {
        let f = deformation(point, moved_mm);
        let (inverse, j) = inverted(&f);
        if j <= 0.0 || !j.is_finite() {
            return None;
        }
        let weight = point.volume_mm3;
        volume = (volume.0 + weight, volume.1 + weight * j);
        // Gradients in the deformed brick, and F times the gradients in the undeformed one.
        let spatial: [Point; CORNERS] = point
            .gradients
            .map(|n| std::array::from_fn(|i| (0..3).map(|l| inverse[l][i] * n[l]).sum()));
        let carried: [Point; CORNERS] = point
            .gradients
            .map(|n| std::array::from_fn(|i| (0..3).map(|l| f[i][l] * n[l]).sum()));
        let first: f64 = f.iter().flatten().map(|entry| entry * entry).sum();
        let scale = weight * rubber.shear_kpa / libm::cbrt(j * j);
        for a in 0..CORNERS {
            for i in 0..3 {
                let row = 3 * a + i;
                out.forces[row] += scale * (carried[a][i] - first / 3.0 * spatial[a][i]);
                swell[row] += weight * j * spatial[a][i];
            }
            for b in 0..=a {
                let (na, nb) = (point.gradients[a], point.gradients[b]);
                let dot = na[0] * nb[0] + na[1] * nb[1] + na[2] * nb[2];
                for i in 0..3 {
                    for k in 0..3 {
                        let same = if i == k { dot } else { 0.0 };
                        let value = same
                            - 2.0 / 3.0
                                * (carried[a][i] * spatial[b][k] + spatial[a][i] * carried[b][k])
                            + 2.0 / 9.0 * first * spatial[a][i] * spatial[b][k]
                            + first / 3.0 * spatial[b][i] * spatial[a][k];
                        out.stiffness[3 * a + i][3 * b + k] += scale * value;
                    }
                }
            }
        }
        *turned = (spatial, weight * j);
    }
    let pressure = rubber.bulk_kpa * (volume.1 / volume.0 - 1.0);
    let stiff = rubber.bulk_kpa / volume.0;
    for (force, swell) in out.forces.iter_mut().zip(&swell) {
        *force += pressure * swell;
    }
    out.pressure_kpa = pressure;
    out.pressure_slope = swell.map(|swell| stiff * swell);
    let bent_by = foretold_kpa.unwrap_or(pressure);
    for a in 0..CORNERS {
        for b in 0..=a {
            for i in 0..3 {
                for k in 0..3 {
                    let second: f64 = turned
                        .iter()
                        .map(|(g, weight)| weight * (g[a][i] * g[b][k] - g[b][i] * g[a][k]))
                        .sum();
                    out.stiffness[3 * a + i][3 * b + k] +=
                        bent_by * second + stiff * swell[3 * a + i] * swell[3 * b + k];
                }
            }
        }
    }
    for row in 0..DOFS {
        for column in row + 1..DOFS {
            out.stiffness[row][column] = out.stiffness[column][row];
        }
    }
    Some(out)
}

/// The deformation gradient at one of a brick's points, scaled so that its change of volume is the whole brick's.
pub(super) fn mean_gradient(
    points: &[GaussPoint; 8],
    moved_mm: &[Point; CORNERS],
    point: usize,
) -> Gradient {
    let swell = |point: &GaussPoint| inverted(&deformation(point, moved_mm)).1;
    let at_rest: f64 = points.iter().map(|point| point.volume_mm3).sum();
    let now: f64 = points
        .iter()
        .map(|point| point.volume_mm3 * swell(point))
        .sum();
    let scale = libm::cbrt(now / at_rest / swell(&points[point]));
    deformation(&points[point], moved_mm).map(|row| row.map(|entry| scale * entry))
}

/// The deformation gradient F at a point.
fn deformation(point: &GaussPoint, moved_mm: &[Point; CORNERS]) -> Gradient {
    let mut f = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (n, u) in point.gradients.iter().zip(moved_mm) {
        for i in 0..3 {
            for l in 0..3 {
                f[i][l] += u[i] * n[l];
            }
        }
    }
    f
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::solid::bricks::gauss_points;

    #[test]
    fn the_stiffness_is_the_derivative_of_the_forces() {
        let cube: [Point; CORNERS] = std::array::from_fn(|corner| {
            std::array::from_fn(|axis| {
                f64::from(u8::from(corner >> axis & 1 == 1)) * (1.0 + 0.3 * axis as f64)
                    + 0.05 * ((corner * 3 + axis) % 5) as f64
            })
        });
        let moved: [Point; CORNERS] = std::array::from_fn(|corner| {
            std::array::from_fn(|axis| 0.1 * (((corner * 7 + axis * 5) % 11) as f64 / 11.0 - 0.5))
        });
        let rubber = Rubber::from_young(60.0, 0.49);
        let points = gauss_points(&cube);
        let there = answer(&points, &moved, rubber, None).expect("sound");
        let step = 1e-6;
        for column in 0..DOFS {
            let shifted = |by: f64| {
                let mut moved = moved;
                moved[column / 3][column % 3] += by;
                answer(&points, &moved, rubber, None).expect("sound").forces
            };
            let (more, less) = (shifted(step), shifted(-step));
            for row in 0..DOFS {
                let slope = (more[row] - less[row]) / (2.0 * step);
                let exact = there.stiffness[row][column];
                assert!(
                    (slope - exact).abs() < 1e-3 * rubber.bulk_kpa,
                    "{row} {column}: {slope} {exact}"
                );
            }
        }
    }
}
