//! The colours of images: one scale for every picture of the pad.

/// A perceptually even scale from near-black over violet and orange to pale yellow, for a value 0..1, as sRGB. Its
/// lightness rises all the way: it reads the same without colour vision.
#[must_use]
pub fn heat(value: f32) -> [u8; 3] {
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
