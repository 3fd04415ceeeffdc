//! A table of responses as bytes: for a cache on disk and for recordings.
//!
//! Little-endian: magic, length of the key and the key, six dimensions (u32), the pitch in mm (f64), basis and terms (f32), CRC-32 of all
//! before it.

use crc::{CRC_32_ISO_HDLC, Crc, Table};

use super::{LANES, POWERS, Places, RADII, ResponseTable};

/// Vectors a place.
const SAMPLES: usize = RADII * POWERS;
const MAGIC: &[u8; 8] = b"gelpadR1";
/// Sixteen bytes a step: a table of fifteen megabytes is checked at every start.
static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);
/// No dimension of a real table comes near this.
const MOST: usize = 1 << 16;

/// Why bytes are no table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// Another kind of file, or of another version.
    #[error("this is no table of responses of this version")]
    NotATable,
    /// Cut or changed.
    #[error("the table of responses is damaged")]
    Damaged,
}

impl ResponseTable {
    /// All of it.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(4 * (self.terms.len() + self.basis.len()) + 4096);
        bytes.extend_from_slice(MAGIC);
        let dimensions = [
            self.key.len(),
            self.channels,
            self.rank,
            self.places.columns,
            self.places.rows,
            SAMPLES,
        ];
        for value in dimensions {
            bytes.extend_from_slice(&(value as u32).to_le_bytes());
        }
        bytes.extend_from_slice(&self.places.pitch_mm.to_le_bytes());
        bytes.extend_from_slice(self.key.as_bytes());
        for value in self.basis.iter().chain(&self.terms) {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        let sum = CRC.checksum(&bytes);
        bytes.extend_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// A table from what [`Self::to_bytes`] gave.
    ///
    /// # Errors
    /// Bytes of something else, or damaged ones.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TableError> {
        let rest = bytes.strip_prefix(MAGIC).ok_or(TableError::NotATable)?;
        let whole = bytes
            .split_last_chunk::<4>()
            .filter(|(before, sum)| CRC.checksum(before) == u32::from_le_bytes(**sum));
        let (_, _) = whole.ok_or(TableError::Damaged)?;
        let mut reader = Reader(&rest[..rest.len() - 4]);
        let [key, channels, rank, columns, rows, terms] = [(); 6].map(|()| reader.dimension());
        let dimensions = [key?, channels?, rank?, columns?, rows?];
        let [key, channels, rank, columns, rows] = dimensions;
        if terms? != SAMPLES
            || dimensions.iter().any(|value| *value > MOST)
            || columns < 4
            || rows < 4
            || rank % LANES != 0
        {
            return Err(TableError::NotATable);
        }
        let pitch_mm = f64::from_le_bytes(reader.take()?);
        let key = reader.bytes(key)?;
        let table = Self {
            key: String::from_utf8(key.to_vec()).map_err(|_| TableError::Damaged)?,
            channels,
            rank,
            basis: reader.values(rank * channels)?,
            places: Places {
                pitch_mm,
                columns,
                rows,
            },
            terms: reader.values(columns * rows * SAMPLES * rank)?,
        };
        if reader.0.is_empty() {
            Ok(table)
        } else {
            Err(TableError::Damaged)
        }
    }
}

/// What is left to read.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], TableError> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(TableError::Damaged)?;
        self.0 = rest;
        Ok(taken)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], TableError> {
        let (taken, rest) = self.0.split_first_chunk::<N>().ok_or(TableError::Damaged)?;
        self.0 = rest;
        Ok(*taken)
    }

    fn dimension(&mut self) -> Result<usize, TableError> {
        Ok(u32::from_le_bytes(self.take()?) as usize)
    }

    fn values(&mut self, count: usize) -> Result<Vec<f32>, TableError> {
        let bytes = self.bytes(4 * count)?;
        let (values, _) = bytes.as_chunks::<4>();
        Ok(values
            .iter()
            .map(|value| f32::from_le_bytes(*value))
            .collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let table = ResponseTable::small();
        assert_eq!(ResponseTable::from_bytes(&table.to_bytes()), Ok(table));
    }

    #[test]
    fn a_cut_table_is_damaged_and_something_else_is_no_table() {
        let bytes = ResponseTable::small().to_bytes();
        let cut = &bytes[..bytes.len() - 9];
        assert_eq!(ResponseTable::from_bytes(cut), Err(TableError::Damaged));
        let other = ResponseTable::from_bytes(b"t_ms,v0,v1");
        assert_eq!(other, Err(TableError::NotATable));
    }

    proptest! {
        #[test]
        fn no_flipped_bit_goes_unseen(at in 8..100_000usize, bit in 0..8u8) {
            let mut bytes = ResponseTable::small().to_bytes();
            let at = at % bytes.len();
            bytes[at] ^= 1 << bit;
            prop_assert!(ResponseTable::from_bytes(&bytes).is_err());
        }
    }
}
