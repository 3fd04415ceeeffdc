//! Weights of interpolation by cubic convolution: a table's places and radii, and its places of stretches.

/// Closer than this to a grid point, in steps, a coordinate is at it.
const AT_POINT: f64 = 1e-9;

/// Weights of the four grid points around a coordinate (cubic convolution: Keys 1981, IEEE Trans. ASSP 29, eq. 15).
pub(super) struct Cubic {
    pub(super) first: usize,
    pub(super) value: [f32; 4],
    pub(super) slope: [f32; 4],
}

impl Cubic {
    /// `at` counts steps from the first of `count` points; it is clamped to the second and the last but one. NaN, too,
    /// becomes the second.
    pub(super) fn at(at: f64, count: usize) -> Self {
        let last = (count - 2) as f64;
        let at = at.max(1.0).min(last);
        let nearest = libm::round(at);
        let is_at_point = (at - nearest).abs() < AT_POINT;
        let at = if is_at_point { nearest } else { at };
        let cell = libm::floor(at).min(last - 1.0);
        let f = at - cell;
        let (f2, f3) = (f * f, f * f * f);
        let value = [
            0.5 * (2.0 * f2 - f3 - f),
            0.5 * (3.0 * f3 - 5.0 * f2 + 2.0),
            0.5 * (4.0 * f2 - 3.0 * f3 + f),
            0.5 * (f3 - f2),
        ];
        let slope = [
            0.5 * (4.0 * f - 3.0 * f2 - 1.0),
            0.5 * (9.0 * f2 - 10.0 * f),
            0.5 * (8.0 * f - 9.0 * f2 + 1.0),
            0.5 * (3.0 * f2 - 2.0 * f),
        ];
        Self {
            first: cell as usize - 1,
            value: value.map(|weight| weight as f32),
            slope: slope.map(|weight| weight as f32),
        }
    }

    /// With the slope per unit instead of per step; a step is `step` units long.
    pub(super) fn per(mut self, step: f64) -> Self {
        self.slope = self.slope.map(|slope| slope / step as f32);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_touch_at_a_grid_point_has_one_weight() {
        // As rounding makes them: a hair beside the second, third and last point.
        for (at, first) in [(1.0, 0), (2.0 + 1e-12, 1), (2.0 - 1e-12, 1), (8.0, 6)] {
            let cubic = Cubic::at(at, 10);
            let ones = cubic.value.iter().filter(|weight| **weight == 1.0);
            let zeros = cubic.value.iter().filter(|weight| **weight == 0.0);
            assert_eq!(
                (ones.count(), zeros.count()),
                (1, 3),
                "{at}: {:?}",
                cubic.value
            );
            assert_eq!(cubic.first, first, "{at}");
        }
    }
}
