//! The colour scale of all images.

/// The sRGB colour of a value from 0 to 1, on a perceptually uniform scale from near-black through violet and orange to
/// pale yellow. Lightness increases with the value, so the scale works without colour vision.
#[must_use]
pub fn heat_colour(value: f32) -> [u8; 3] {
    const STOPS: [[f32; 3]; 6] = [
        [10.0, 8.0, 24.0],
        [66.0, 18.0, 104.0],
        [140.0, 41.0, 99.0],
        [214.0, 76.0, 62.0],
        [249.0, 153.0, 28.0],
        [252.0, 250.0, 170.0],
    ];
    let at = value.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let low = (at as usize).min(STOPS.len() - 2);
    let share = at - low as f32;
    std::array::from_fn(|i| {
        let (a, b) = (STOPS[low][i], STOPS[low + 1][i]);
        libm::roundf(a + share * (b - a)) as u8
    })
}
