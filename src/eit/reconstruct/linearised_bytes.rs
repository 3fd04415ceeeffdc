//! The linearised pad as bytes, for the cache on disk: solving one takes half of the time of a start.
//!
//! Little-endian: magic; length of the key, channels and active pixels (u32 each); the key; the active pixels (u32); the
//! coverage of all pixels and the Jacobian by columns (f64); CRC-64 of everything before it.
//!
//! The pixels follow from the pad. Nothing is allocated before the stored dimensions agree with it.

use crc::{CRC_64_XZ, Crc, Table};
use faer::Mat;

use super::linearised::{Linearised, MOST_PIXELS, PIXEL_MM, pixel_grid};
use crate::eit::ResponseBuilder;
use crate::pad::Pad;
use crate::types::ByteReader;

const MAGIC: &[u8; 8] = b"gelpadL1";
/// Part of the key. Raise it when the mesh, the forward model or the Jacobian changes.
const VERSION: u32 = 1;
static CRC: Crc<u64, Table<16>> = Crc::<u64, Table<16>>::new(&CRC_64_XZ);

impl Linearised {
    /// The key of a pad's linearisation: equal for equal pads and the same version of the solver.
    #[must_use]
    pub fn key(pad: &Pad) -> String {
        let pad = ResponseBuilder::key(pad);
        format!("linearised {VERSION} {PIXEL_MM} {MOST_PIXELS} {pad}")
    }

    /// The linearised pad as bytes, with its key.
    #[must_use]
    pub fn to_bytes(&self, key: &str) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        for count in [key.len(), self.jacobian.nrows(), self.active.len()] {
            bytes.extend_from_slice(&(count as u32).to_le_bytes());
        }
        bytes.extend_from_slice(key.as_bytes());
        for pixel in &self.active {
            bytes.extend_from_slice(&(*pixel as u32).to_le_bytes());
        }
        let entries = self.jacobian.col_iter().flat_map(|column| column.iter());
        for value in self.coverage.iter().chain(entries) {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        let sum = CRC.checksum(&bytes);
        bytes.extend_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// Reads and checks a pad's linearisation; `None` if the bytes are damaged, or of another pad or version.
    #[must_use]
    pub fn from_bytes(bytes: &[u8], pad: &Pad, key: &str) -> Option<Self> {
        let (body, sum) = bytes.split_last_chunk::<8>()?;
        let mut reader = ByteReader::new(body.strip_prefix(MAGIC)?);
        let [key_length, channels, active] = [reader.u32()?, reader.u32()?, reader.u32()?];
        let grid = pixel_grid(pad);
        let pixels = grid.columns * grid.rows;
        let (channels, active) = (channels as usize, active as usize);
        let is_of_pad = reader.bytes(key_length as usize)? == key.as_bytes()
            && channels == pad.channels()
            && active <= pixels;
        if !is_of_pad || CRC.checksum(body) != u64::from_le_bytes(*sum) {
            return None;
        }
        let active = reader.u32s(active)?;
        let coverage = reader.f64s(pixels)?;
        let jacobian = reader.f64s(channels * active.len())?;
        let is_valid = reader.rest().is_empty()
            && active.is_sorted_by(|one, next| one < next)
            && active.last().is_none_or(|last| (*last as usize) < pixels)
            && coverage.iter().chain(&jacobian).all(|v| v.is_finite());
        is_valid.then(|| Self {
            grid,
            jacobian: Mat::from_fn(channels, active.len(), |channel, column| {
                jacobian[column * channels + channel]
            }),
            active: active.into_iter().map(|pixel| pixel as usize).collect(),
            coverage,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;
    use crate::pad::shipped_pad;
    use proptest::prelude::*;

    /// A pad, its key, and the bytes of its linearisation.
    static SOLVED: LazyLock<(Pad, String, Vec<u8>)> = LazyLock::new(|| {
        let text = shipped_pad("round-tank").expect("shipped").toml;
        let pad = Pad::from_toml("round-tank", text).expect("sound");
        let key = Linearised::key(&pad);
        let linearised = Linearised::from_pad(&pad).expect("solvable");
        let bytes = linearised.to_bytes(&key);
        (pad, key, bytes)
    });

    /// The bytes with some replaced, and a checksum that is right again.
    fn edited(at: usize, with: &[u8]) -> Vec<u8> {
        let mut bytes = SOLVED.2.clone();
        bytes[at..at + with.len()].copy_from_slice(with);
        let body = bytes.len() - 8;
        let sum = CRC.checksum(&bytes[..body]).to_le_bytes();
        bytes[body..].copy_from_slice(&sum);
        bytes
    }

    #[test]
    fn a_linearised_pad_is_read_to_the_bit() {
        let (pad, key, bytes) = &*SOLVED;
        let read = Linearised::from_bytes(bytes, pad, key).expect("sound");
        let solved = Linearised::from_pad(pad).expect("solvable");
        assert_eq!(read.grid, solved.grid);
        assert_eq!(read.active, solved.active);
        assert_eq!(read.coverage, solved.coverage);
        assert_eq!(read.jacobian, solved.jacobian);
    }

    #[test]
    fn another_pads_bytes_are_refused() {
        let (pad, key, bytes) = &*SOLVED;
        let mut thicker = pad.clone();
        thicker.thickness_mm *= 1.01;
        let other = Linearised::key(&thicker);
        assert_ne!(&other, key);
        assert!(Linearised::from_bytes(bytes, &thicker, &other).is_none());
    }

    #[test]
    fn dimensions_and_values_that_no_solver_gives_are_refused() {
        let (pad, key, bytes) = &*SOLVED;
        for index in 0..3 {
            for value in [0, 3, 1 << 16, u32::MAX] {
                let edited = edited(8 + 4 * index, &value.to_le_bytes());
                let read = Linearised::from_bytes(&edited, pad, key);
                assert!(read.is_none(), "{value} as dimension {index}");
            }
        }
        let first_pixel = 8 + 3 * 4 + key.len();
        let edited_pixel = edited(first_pixel, &u32::MAX.to_le_bytes());
        assert!(Linearised::from_bytes(&edited_pixel, pad, key).is_none());
        let last_value = bytes.len() - 16;
        for value in [f64::NAN, f64::INFINITY] {
            let edited = edited(last_value, &value.to_le_bytes());
            assert!(Linearised::from_bytes(&edited, pad, key).is_none());
        }
    }

    proptest! {
        #[test]
        fn every_flipped_bit_and_every_cut_is_refused(at in 0..10_000_000usize, bit in 0..8u8) {
            let (pad, key, bytes) = &*SOLVED;
            let at = at % bytes.len();
            prop_assert!(Linearised::from_bytes(&bytes[..at], pad, key).is_none());
            let mut bytes = bytes.clone();
            bytes[at] ^= 1 << bit;
            prop_assert!(Linearised::from_bytes(&bytes, pad, key).is_none());
        }
    }
}
