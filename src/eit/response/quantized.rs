//! The terms of a table as small integers, which compress to a quarter.
//!
//! Terms are rounded when they are solved, so play, cache and recordings use the same bits. The step of a term is a power of
//! two, so its multiples are exact in f32. A touch's response is its terms times the square of its radius, so the step
//! falls with the radius.
//!
//! Bytes: the difference of each integer to the one of the place before, zigzag (0, -1, 1, -2 are 0, 1, 2, 3), as u32; first
//! the lowest byte of all of them, then the next, up to the highest.

use super::places::Places;
use super::terms::{POWERS, TERMS};

/// The step of a response at strength 1, as a power of two: 15e-6 of a reading. The error of a response, below 5e-6 (root mean
/// square), is a twentieth of the noise at 80 dB.
pub(super) const STEP_LOG2: f64 = -16.0;
/// Bytes of an integer.
const BYTES: usize = 4;

/// Rounds terms: places x radii x powers x rank.
pub(super) fn round(terms: &mut [f32], places: &Places, rank: usize) {
    let steps = steps(places);
    for (terms, step) in terms
        .chunks_exact_mut(POWERS * rank)
        .zip(steps.iter().cycle())
    {
        for term in terms {
            // No response of a real pad comes near the bound. Plus zero, since a negative zero would not come back.
            let integer = libm::roundf(*term / step).clamp(i32::MIN as f32, i32::MAX as f32);
            *term = integer * step + 0.0;
        }
    }
}

/// Rounded terms as bytes; `None` if one is not rounded.
pub(super) fn pack<'a>(
    terms: impl Iterator<Item = &'a f32>,
    places: &Places,
    rank: usize,
) -> Option<Vec<u8>> {
    let steps = steps(places);
    let integers: Option<Vec<i32>> = terms
        .enumerate()
        .map(|(index, term)| {
            let step = steps[index / (POWERS * rank) % steps.len()];
            let integer = (term / step) as i32;
            (integer as f32 * step == *term).then_some(integer)
        })
        .collect();
    Some(pack_integers(&integers?, TERMS * rank))
}

/// The terms of bytes that [`pack`] made. Any bytes are terms.
pub(super) fn unpack(bytes: &[u8], places: &Places, rank: usize) -> Vec<f32> {
    let steps = steps(places);
    let mut terms = Vec::with_capacity(bytes.len() / BYTES);
    unpack_integers(bytes, TERMS * rank, |integers| {
        for (integers, step) in integers.chunks(POWERS * rank).zip(&steps) {
            terms.extend(integers.iter().map(|integer| *integer as f32 * step));
        }
    });
    terms
}

/// Integers as bytes; so many belong to one place.
pub(super) fn pack_integers(integers: &[i32], of_place: usize) -> Vec<u8> {
    let count = integers.len();
    let mut bytes = vec![0; BYTES * count];
    for (index, integer) in integers.iter().enumerate() {
        let before = index.checked_sub(of_place).map_or(0, |at| integers[at]);
        let difference = integer.wrapping_sub(before);
        let zigzag = (difference << 1) ^ (difference >> 31);
        for (plane, byte) in zigzag.to_le_bytes().into_iter().enumerate() {
            bytes[plane * count + index] = byte;
        }
    }
    bytes
}

/// Hands on the integers of each place in turn, of bytes that [`pack_integers`] made.
pub(super) fn unpack_integers(bytes: &[u8], of_place: usize, mut place: impl FnMut(&[i32])) {
    let count = bytes.len() / BYTES;
    let [first, second, third, highest] =
        [0, 1, 2, 3].map(|plane| &bytes[plane * count..][..count]);
    // The integers of one place, from which those of the next differ.
    let mut integers = vec![0i32; of_place];
    for start in (0..count).step_by(integers.len()) {
        let end = count.min(start + integers.len());
        let planes = [first, second, third, highest].map(|plane| &plane[start..end]);
        for (index, integer) in integers[..end - start].iter_mut().enumerate() {
            let zigzag = u32::from_le_bytes(planes.map(|plane| plane[index]));
            let difference = (zigzag >> 1) as i32 ^ -((zigzag & 1) as i32);
            *integer = integer.wrapping_add(difference);
        }
        place(&integers[..end - start]);
    }
}

/// The step of the terms of each radius.
fn steps(places: &Places) -> Vec<f32> {
    let step = |radius_mm: &f64| {
        let exponent = libm::floor(STEP_LOG2 - 2.0 * libm::log2(*radius_mm));
        libm::ldexp(1.0, exponent as i32) as f32
    };
    places.radii_mm().iter().map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RANK: usize = 8;

    proptest! {
        #[test]
        fn rounded_terms_are_restored_to_the_bit(
            mut terms in proptest::collection::vec(-1e6..1e6f32, 3 * TERMS * RANK),
            scale in 0..60i32,
        ) {
            let places = Places::new([60.0, 40.0]);
            terms.iter_mut().for_each(|term| *term *= libm::exp2f(-scale as f32));
            let exact = terms.clone();
            round(&mut terms, &places, RANK);
            for (radius, step) in steps(&places).iter().enumerate() {
                let first = radius * POWERS * RANK;
                let most = i32::MAX as f32 * step;
                let bounded = exact[first].clamp(-most, most);
                prop_assert!((terms[first] - bounded).abs() <= step / 2.0);
            }
            let bytes = pack(terms.iter(), &places, RANK).expect("rounded");
            let back = unpack(&bytes, &places, RANK);
            prop_assert!(back.iter().zip(&terms).all(|(a, b)| a == b));
        }
    }

    #[test]
    fn terms_that_are_not_rounded_are_not_packed() {
        let places = Places::new([60.0, 40.0]);
        let terms = vec![0.1; TERMS * RANK];
        assert_eq!(pack(terms.iter(), &places, RANK), None);
    }
}
