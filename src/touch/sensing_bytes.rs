//! What a pad's frames are read with, as bytes: for recordings, which bring their own.
//!
//! Matrix and weights come out of a solver whose last bits depend on the processor; a recording keeps them, and the same
//! frames give the same events on any machine. The table of responses is not in these bytes: it is large, never changes, and has bytes of
//! its own.
//!
//! Little-endian: magic, the reconstruction, the number of channels (u32), deviations (f64), image weights (f32), a 1 and
//! the weights of the locating or a 0, CRC-32 of all before it.

use std::sync::Arc;

use crc::{CRC_32_ISO_HDLC, Crc, Table};

use super::{Locating, Sensing};
use crate::eit::{Reconstruction, ResponseTable};
use crate::pad::Outline;
use crate::types::ByteReader;

const MAGIC: &[u8; 8] = b"gelpadS1";
static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);

/// Why bytes are no matrix and weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SensingError {
    /// Another kind of bytes, or of another version.
    #[error("this is no matrix of this version")]
    NotSensing,
    /// Cut or changed.
    #[error("the matrix is damaged")]
    Damaged,
    /// It locates touches by a table, and that is missing or another pad's.
    #[error("the matrix' table of responses is missing")]
    NoTable,
}

impl Sensing {
    /// All of it but the table of responses.
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
        bytes.push(u8::from(self.locating.is_some()));
        if let Some(locating) = &self.locating {
            locating.to_bytes(&mut bytes);
        }
        let sum = CRC.checksum(&bytes);
        bytes.extend_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// From what [`Self::to_bytes`] gave, the table that it was made with, and the pad's outline.
    ///
    /// # Errors
    /// Bytes of something else, or damaged ones; a table that does not fit.
    pub fn from_bytes(
        bytes: &[u8],
        table: Option<&Arc<ResponseTable>>,
        outline: &Outline,
    ) -> Result<Self, SensingError> {
        let rest = bytes.strip_prefix(MAGIC).ok_or(SensingError::NotSensing)?;
        bytes
            .split_last_chunk::<4>()
            .filter(|(before, sum)| CRC.checksum(before) == u32::from_le_bytes(**sum))
            .ok_or(SensingError::Damaged)?;
        let mut reader = ByteReader::new(&rest[..rest.len().saturating_sub(4)]);
        let damaged = SensingError::Damaged;
        let reconstruction = Reconstruction::from_bytes(&mut reader).ok_or(damaged)?;
        let channels = reader.count().ok_or(damaged)?;
        let deviations = reader.f64s(channels).ok_or(damaged)?;
        let image_weights = reader.f32s(channels).ok_or(damaged)?;
        let locating = match reader.u8() {
            Some(0) => None,
            Some(1) => {
                let table = table
                    .filter(|table| table.channels() == channels)
                    .ok_or(SensingError::NoTable)?;
                let locating = Locating::from_bytes(&mut reader, Arc::clone(table), outline);
                Some(Arc::new(locating.ok_or(damaged)?))
            }
            _ => return Err(damaged),
        };
        if !reader.rest().is_empty() || reconstruction.channels() != channels {
            return Err(damaged);
        }
        Ok(Self {
            reconstruction: Arc::new(reconstruction),
            locating,
            deviations,
            image_weights,
        })
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
    fn matrices_of_both_kinds_come_back_to_the_bit() {
        for method in [Method::Noser, Method::L1] {
            let (pad, builder) = builder(method);
            let mut deviations = vec![1e-3; pad.channels()];
            deviations[7] = f64::INFINITY;
            deviations[9] = 2.5e-3;
            let sensing = builder.build(&deviations).expect("built");
            let bytes = sensing.to_bytes();
            let back = Sensing::from_bytes(&bytes, None, &pad.outline).expect("sound");
            assert_eq!(back.reconstruction, sensing.reconstruction);
            assert_eq!(back.deviations, sensing.deviations);
            assert_eq!(back.image_weights, sensing.image_weights);
            assert_eq!(back.to_bytes(), bytes);
        }
    }

    #[test]
    fn damage_is_seen() {
        let (pad, builder) = builder(Method::Noser);
        let bytes = builder.first().expect("built").to_bytes();
        let read = |bytes: &[u8]| Sensing::from_bytes(bytes, None, &pad.outline).err();
        let mut flipped = bytes.clone();
        flipped[bytes.len() / 2] ^= 4;
        assert_eq!(read(&flipped), Some(SensingError::Damaged));
        assert_eq!(read(&bytes[..bytes.len() / 2]), Some(SensingError::Damaged));
        assert_eq!(read(b"gelpadR1"), Some(SensingError::NotSensing));
    }
}
