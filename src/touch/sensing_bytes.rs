//! [`Sensing`] as bytes, for recordings.
//!
//! The last bits of matrix and weights depend on the processor that solved for them. A recording stores them, so the same
//! frames give the same events on any machine. The response table is large and never changes; it is stored separately.
//!
//! Little-endian: magic; the reconstruction; the number of channels (u32); deviations (f64); image weights (f32); a 1 and
//! the weights of the locator, or a 0; CRC-32 of everything before it.

use std::sync::Arc;

use crc::{CRC_32_ISO_HDLC, Crc, Table};

use super::locate::LocatedPad;
use super::{LocatorModel, Sensing};
use crate::eit::{Reconstruction, ResponseTable, SharedNoise};
use crate::pad::Pad;
use crate::types::ByteReader;

const MAGIC: &[u8; 8] = b"gelpadS2";
/// The format before channels shared noise.
const FIRST_MAGIC: &[u8; 8] = b"gelpadS1";
static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);

/// Why bytes are not the [`Sensing`] of a pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SensingError {
    /// Another kind of bytes, or another version.
    #[error("this is not a reconstruction matrix of this version")]
    NotSensing,
    /// Cut short or changed.
    #[error("the reconstruction matrix is damaged")]
    Damaged,
    /// It belongs to another pad, or holds values that no solver gives.
    #[error("the reconstruction matrix does not fit the pad, or has values out of range")]
    Invalid,
    /// It locates touches with a response table, which is missing.
    #[error("the response table of the reconstruction matrix is missing")]
    NoTable,
}

impl Sensing {
    /// Everything except the response table.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        self.reconstruction.to_bytes(&mut bytes);
        bytes.extend_from_slice(&(self.channels() as u32).to_le_bytes());
        for deviation in &self.deviations {
            bytes.extend_from_slice(&deviation.to_le_bytes());
        }
        for weight in &self.image_weights {
            bytes.extend_from_slice(&weight.to_le_bytes());
        }
        for variance in [self.shared.gain, self.shared.drive] {
            bytes.extend_from_slice(&variance.to_le_bytes());
        }
        bytes.push(u8::from(self.locator_model.is_some()));
        if let Some(locating) = &self.locator_model {
            locating.to_bytes(&mut bytes);
        }
        let sum = CRC.checksum(&bytes);
        bytes.extend_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// Reads and checks the sensing of a pad; `table` is the pad's response table.
    ///
    /// # Errors
    /// See [`SensingError`].
    pub fn from_bytes(
        bytes: &[u8],
        table: Option<&Arc<ResponseTable>>,
        pad: &Pad,
    ) -> Result<Self, SensingError> {
        let (rest, has_shared) = match (bytes.strip_prefix(MAGIC), bytes.strip_prefix(FIRST_MAGIC))
        {
            (Some(rest), _) => (rest, true),
            (None, Some(rest)) => (rest, false),
            (None, None) => return Err(SensingError::NotSensing),
        };
        bytes
            .split_last_chunk::<4>()
            .filter(|(before, sum)| CRC.checksum(before) == u32::from_le_bytes(**sum))
            .ok_or(SensingError::Damaged)?;
        let mut reader = ByteReader::new(&rest[..rest.len().saturating_sub(4)]);
        let invalid = SensingError::Invalid;
        let reconstruction = Reconstruction::from_bytes(&mut reader, pad).ok_or(invalid)?;
        let channels = reader.u32().ok_or(invalid)? as usize;
        if channels != pad.channels() {
            return Err(invalid);
        }
        let deviations = reader.f64s(channels).ok_or(invalid)?;
        let image_weights = reader.f32s(channels).ok_or(invalid)?;
        let shared = match has_shared {
            true => read_shared_noise(&mut reader).ok_or(invalid)?,
            false => SharedNoise::default(),
        };
        let locator_model = read_locator_model(&mut reader, table, pad)?;
        // An infinite deviation excludes a channel.
        let is_valid = reader.rest().is_empty()
            && deviations.iter().all(|deviation| *deviation > 0.0)
            && [shared.gain, shared.drive]
                .iter()
                .all(|variance| variance.is_finite() && *variance >= 0.0)
            && image_weights
                .iter()
                .all(|weight| weight.is_finite() && *weight >= 0.0);
        if !is_valid {
            return Err(invalid);
        }
        Ok(Self {
            reconstruction: Arc::new(reconstruction),
            locator_model,
            deviations,
            shared,
            image_weights,
        })
    }
}

fn read_shared_noise(reader: &mut ByteReader<'_>) -> Option<SharedNoise> {
    let variances = reader.f64s(2)?;
    Some(SharedNoise {
        gain: variances[0],
        drive: variances[1],
    })
}

fn read_locator_model(
    reader: &mut ByteReader<'_>,
    table: Option<&Arc<ResponseTable>>,
    pad: &Pad,
) -> Result<Option<Arc<LocatorModel>>, SensingError> {
    match reader.u8() {
        Some(0) => Ok(None),
        Some(1) => {
            let table = table
                .filter(|table| table.channels() == pad.channels())
                .ok_or(SensingError::NoTable)?;
            let pad = LocatedPad::from(pad);
            let model = LocatorModel::from_bytes(reader, Arc::clone(table), &pad);
            Ok(Some(Arc::new(model.ok_or(SensingError::Invalid)?)))
        }
        _ => Err(SensingError::Invalid),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};
    use crate::touch::SensingBuilder;
    use crate::types::Method;

    fn builder(method: Method) -> (Pad, SensingBuilder) {
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        let pad = Pad::from_toml("p", text).expect("sound");
        let builder = SensingBuilder::new(&pad, method).expect("solvable");
        (pad, builder)
    }

    #[test]
    fn both_kinds_of_matrix_survive_a_round_trip_bit_for_bit() {
        for method in [Method::Noser, Method::L1] {
            let (pad, builder) = builder(method);
            let mut deviations = vec![1e-3; pad.channels()];
            deviations[7] = f64::INFINITY;
            deviations[9] = 2.5e-3;
            let sensing = builder.build(&deviations.into()).expect("built");
            let bytes = sensing.to_bytes();
            let back = Sensing::from_bytes(&bytes, None, &pad).expect("valid");
            assert_eq!(back.reconstruction, sensing.reconstruction);
            assert_eq!(back.deviations, sensing.deviations);
            assert_eq!(back.image_weights, sensing.image_weights);
            assert_eq!(back.to_bytes(), bytes);
        }
    }

    #[test]
    fn damage_is_detected() {
        let (pad, builder) = builder(Method::Noser);
        let bytes = builder.build_initial().expect("built").to_bytes();
        let read = |bytes: &[u8]| Sensing::from_bytes(bytes, None, &pad).err();
        let mut flipped = bytes.clone();
        flipped[bytes.len() / 2] ^= 4;
        assert_eq!(read(&flipped), Some(SensingError::Damaged));
        assert_eq!(read(&bytes[..bytes.len() / 2]), Some(SensingError::Damaged));
        assert_eq!(read(b"gelpadR1"), Some(SensingError::NotSensing));
    }

    /// The bytes with some replaced, and a checksum that is right again.
    fn edited(bytes: &[u8], at: usize, with: &[u8]) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        bytes[at..at + with.len()].copy_from_slice(with);
        let body = bytes.len() - 4;
        let sum = CRC.checksum(&bytes[..body]).to_le_bytes();
        bytes[body..].copy_from_slice(&sum);
        bytes
    }

    #[test]
    fn a_matrix_with_another_grid_or_values_out_of_range_is_refused() {
        let [sign_at, pixel_at, columns_at, coverage_at] = [10, 30, 38, 46];
        let (pad, builder) = builder(Method::Noser);
        let sensing = builder.build_initial().expect("built");
        let bytes = sensing.to_bytes();
        let refused = |at: usize, with: &[u8]| {
            let read = Sensing::from_bytes(&edited(&bytes, at, with), None, &pad);
            assert_eq!(read.err(), Some(SensingError::Invalid), "{with:?} at {at}");
        };
        for pixel_mm in [1e-12, 0.0, -2.5, f64::NAN, f64::INFINITY] {
            refused(pixel_at, &pixel_mm.to_le_bytes());
        }
        for value in [f32::NAN, -0.5, 1e30] {
            refused(sign_at, &value.to_le_bytes());
            refused(coverage_at, &value.to_le_bytes());
        }
        refused(columns_at, &u32::MAX.to_le_bytes());
        let active = coverage_at + 4 * sensing.reconstruction.coverage.len();
        refused(active, &u32::MAX.to_le_bytes());
        refused(active + 4, &u32::MAX.to_le_bytes());
        let deviations = bytes.len() - 5 - (4 + 8) * pad.channels();
        for value in [0.0, -1e-3, f64::NAN] {
            refused(deviations, &value.to_le_bytes());
        }
        let matrix = deviations - 4 - 4 * pad.channels();
        refused(matrix, &f32::NAN.to_le_bytes());
        let weights = deviations + 8 * pad.channels();
        refused(weights, &f32::INFINITY.to_le_bytes());
    }
}
