//! The response table as bytes, for the cache on disk and for recordings.
//!
//! Little-endian: magic; six u32 (length of the key, channels, rank, columns, rows, terms per place); the grid's pitch in
//! mm (f64); the key; the basis (f32) and the terms of both signs at the places from which the others follow by symmetry (as in
//! `quantized.rs`); what longer fingers add (`stretch.rs`, as integers, too); CRC-32 of everything before it. The version tells the
//! law by which responses grow with strength (`law.rs`): since the fifth, that of the rise. A learned table, whose law is that of the
//! strength and which does not know what longer fingers add, is of the third version. The others remain for older recordings: the fourth
//! is the fifth with the other law; the second holds the terms as f32; the first, too, of one sign at all places, and no places
//! beyond the edge but those that the interpolation needs.
//!
//! The grid follows from the pad, so stored dimensions are only compared with it. Nothing is allocated before they agree.

use crc::{CRC_32_ISO_HDLC, Crc, Table};

use super::LANES;
use super::law::StrengthLaw;
use super::places::Places;
use super::quantized;
use super::stretch::Stretches;
use super::symmetry::Orbits;
use super::table::ResponseTable;
use super::terms::{SIGNS, TERMS, Terms};
use crate::pad::Pad;
use crate::types::ByteReader;

const MAGIC: &[u8; 8] = b"gelpadR5";
/// With the law of the strength.
const STRENGTH_MAGIC: &[u8; 8] = b"gelpadR4";
/// Without what longer fingers add.
const ROUND_MAGIC: &[u8; 8] = b"gelpadR3";
/// Terms as f32.
const FLOAT_MAGIC: &[u8; 8] = b"gelpadR2";
const OLD_MAGIC: &[u8; 8] = b"gelpadR1";
/// Sixteen bytes per step: a table of fifteen megabytes is checked at every start.
static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);
/// Entries of an orthonormal basis are at most 1, apart from rounding.
const MOST_BASIS: f32 = 1.001;
/// Largest absolute value of a term; those of real pads stay below 1e4.
const MOST_TERM: f32 = 1e6;

/// Why bytes are not a response table of a pad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// Another kind of file, or another version.
    #[error("this is not a response table of this version")]
    NotATable,
    /// Cut short or changed.
    #[error("the response table is damaged")]
    Damaged,
    /// Its channels or its grid are not the pad's.
    #[error("the response table belongs to another pad")]
    OtherPad,
    /// A rank, basis or term that no solver gives.
    #[error("the response table has values out of range")]
    OutOfRange,
}

impl ResponseTable {
    /// The table as bytes.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let solved = self.terms.solved();
        let packed = quantized::pack(solved.iter(), &self.places, self.rank);
        let packed = packed.filter(|_| self.has_both_signs());
        let magic = match packed {
            Some(_) if self.law == StrengthLaw::Rise => MAGIC,
            Some(_) if self.stretches.is_some() => STRENGTH_MAGIC,
            Some(_) => ROUND_MAGIC,
            None if self.has_both_signs() => FLOAT_MAGIC,
            None => OLD_MAGIC,
        };
        let mut bytes = magic.to_vec();
        let dimensions = [
            self.key.len(),
            self.channels,
            self.rank,
            self.places.columns,
            self.places.rows,
            TERMS,
        ];
        for value in dimensions {
            bytes.extend_from_slice(&(value as u32).to_le_bytes());
        }
        bytes.extend_from_slice(&self.places.pitch_mm.to_le_bytes());
        bytes.extend_from_slice(self.key.as_bytes());
        let mut floats = |values: &mut dyn Iterator<Item = &f32>| {
            values.for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
        };
        floats(&mut self.basis.iter());
        match packed {
            Some(packed) => bytes.extend_from_slice(&packed),
            None => floats(&mut solved.iter()),
        }
        let stretches = self.stretches.as_ref();
        if let Some(stretches) = stretches.filter(|_| knows_stretches(magic)) {
            bytes.extend_from_slice(&stretches.pack());
        }
        let sum = CRC.checksum(&bytes);
        bytes.extend_from_slice(&sum.to_le_bytes());
        bytes
    }

    /// Reads and checks a table of a pad.
    ///
    /// # Errors
    /// See [`TableError`].
    pub fn from_bytes(bytes: &[u8], pad: &Pad) -> Result<Self, TableError> {
        let size_mm = pad.outline.size_mm();
        if bytes.starts_with(OLD_MAGIC) {
            let places = Places::old(size_mm);
            let orbits = Orbits::none(&places, pad.channels());
            Self::read(bytes, places, orbits, 1, pad.channels())
        } else {
            let places = Places::new(size_mm);
            let orbits = Orbits::new(pad, &places);
            Self::read(bytes, places, orbits, SIGNS, pad.channels())
        }
    }

    /// Reads a table with the given places and number of signs, after the magic of any version.
    fn read(
        bytes: &[u8],
        places: Places,
        orbits: Orbits,
        signs: usize,
        channels: usize,
    ) -> Result<Self, TableError> {
        let body = checked_body(bytes)?;
        let mut reader = ByteReader::new(body);
        let dimensions = reader.u32s(6).ok_or(TableError::Damaged)?;
        let stored = |index: usize| dimensions[index] as usize;
        let (key_length, rank) = (stored(0), stored(2));
        if stored(5) != TERMS {
            return Err(TableError::NotATable);
        }
        let pitch_mm = reader.f64().ok_or(TableError::Damaged)?;
        if [stored(1), stored(3), stored(4)] != [channels, places.columns, places.rows]
            || pitch_mm != places.pitch_mm
        {
            return Err(TableError::OtherPad);
        }
        if rank == 0 || rank % LANES != 0 || rank > channels.next_multiple_of(LANES) {
            return Err(TableError::OutOfRange);
        }
        let has_stretches = knows_stretches(bytes);
        let law = match bytes.starts_with(MAGIC) {
            true => StrengthLaw::Rise,
            false => StrengthLaw::Strength,
        };
        let is_packed = has_stretches || bytes.starts_with(ROUND_MAGIC);
        let read_terms = |count: usize, reader: &mut ByteReader<'_>| {
            if is_packed {
                let packed = reader.bytes(count.checked_mul(4)?)?;
                Some(quantized::unpack(packed, &places, rank))
            } else {
                reader.f32s(count)
            }
        };
        let stretched = match has_stretches {
            true => 4 * Stretches::count(&places, rank),
            false => 0,
        };
        let (Some(key), Some(basis), Some(terms), Some(stretched), []) = (
            reader.bytes(key_length),
            reader.f32s(rank * channels),
            read_terms(signs * orbits.solved() * TERMS * rank, &mut reader),
            reader.bytes(stretched),
            reader.rest(),
        ) else {
            return Err(TableError::Damaged);
        };
        // NaN is within no bound.
        let within = |values: &[f32], most: f32| values.iter().all(|value| value.abs() <= most);
        if !within(&basis, MOST_BASIS) || !within(&terms, MOST_TERM) {
            return Err(TableError::OutOfRange);
        }
        Ok(Self {
            key: String::from_utf8(key.to_vec()).map_err(|_| TableError::Damaged)?,
            channels,
            rank,
            terms: Terms::new(terms, rank, orbits, &basis),
            basis,
            places,
            law,
            stretches: has_stretches.then(|| Stretches::unpack(stretched, &places, rank)),
        })
    }
}

/// Whether a table that begins so knows what longer fingers add.
fn knows_stretches(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC) || bytes.starts_with(STRENGTH_MAGIC)
}

/// The bytes between the format's name and a checksum that is right.
fn checked_body(bytes: &[u8]) -> Result<&[u8], TableError> {
    let rest = [MAGIC, STRENGTH_MAGIC, ROUND_MAGIC, FLOAT_MAGIC, OLD_MAGIC]
        .iter()
        .find_map(|magic| bytes.strip_prefix(*magic))
        .ok_or(TableError::NotATable)?;
    let (body, _) = rest
        .split_last_chunk::<4>()
        .filter(|(body, sum)| {
            CRC.checksum(&bytes[..MAGIC.len() + body.len()]) == u32::from_le_bytes(**sum)
        })
        .ok_or(TableError::Damaged)?;
    Ok(body)
}

#[cfg(test)]
mod tests {
    use std::sync::OnceLock;

    use super::*;
    use proptest::prelude::*;

    fn read(bytes: &[u8]) -> Result<ResponseTable, TableError> {
        let table = ResponseTable::small();
        let orbits = Orbits::none(&table.places, table.channels);
        ResponseTable::read(bytes, table.places, orbits, SIGNS, table.channels)
    }

    /// The small table's bytes with some replaced, and a checksum that is right again.
    fn edited(at: usize, with: &[u8]) -> Vec<u8> {
        let mut bytes = ResponseTable::small().to_bytes();
        bytes[at..at + with.len()].copy_from_slice(with);
        let body = bytes.len() - 4;
        let sum = CRC.checksum(&bytes[..body]).to_le_bytes();
        bytes[body..].copy_from_slice(&sum);
        bytes
    }

    /// The small table with terms as a solver rounds them.
    fn rounded() -> ResponseTable {
        let mut table = ResponseTable::small();
        let mut terms = table.terms.solved().to_vec();
        quantized::round(&mut terms, &table.places, table.rank);
        let orbits = Orbits::none(&table.places, table.channels);
        table.terms = Terms::new(terms, table.rank, orbits, &table.basis);
        table
    }

    /// The same, knowing what longer fingers add.
    fn stretched() -> ResponseTable {
        let mut table = rounded();
        let count = Stretches::count(&table.places, table.rank);
        let values = (0..count).map(|index| 1e-4 * (index % 97) as f32).collect();
        table.stretches = Some(Stretches::new(values, &table.places, table.rank));
        table
    }

    /// The same, with the law of the rise.
    fn of_rise() -> ResponseTable {
        ResponseTable {
            law: StrengthLaw::Rise,
            ..stretched()
        }
    }

    #[test]
    fn a_table_is_read_as_it_was_written() {
        let tables = [
            (of_rise(), MAGIC),
            (stretched(), STRENGTH_MAGIC),
            (rounded(), ROUND_MAGIC),
            (ResponseTable::small(), FLOAT_MAGIC),
        ];
        for (table, magic) in tables {
            let bytes = table.to_bytes();
            assert!(bytes.starts_with(magic));
            assert_eq!(read(&bytes), Ok(table));
        }
    }

    #[test]
    fn a_cut_table_is_damaged_and_something_else_is_no_table() {
        let bytes = ResponseTable::small().to_bytes();
        assert_eq!(read(&bytes[..bytes.len() - 9]), Err(TableError::Damaged));
        assert_eq!(read(b"t_ms,v0,v1"), Err(TableError::NotATable));
    }

    #[test]
    fn a_pitch_other_than_the_pads_is_refused() {
        const PITCH: usize = 8 + 6 * 4;
        for pitch_mm in [f64::NAN, -1.2, 0.0, 1e-12, f64::INFINITY] {
            let bytes = edited(PITCH, &pitch_mm.to_le_bytes());
            assert_eq!(read(&bytes), Err(TableError::OtherPad), "{pitch_mm} mm");
        }
    }

    #[test]
    fn dimensions_other_than_the_pads_are_refused() {
        let errors = [
            Some(TableError::Damaged),
            Some(TableError::OtherPad),
            Some(TableError::OutOfRange),
            Some(TableError::OtherPad),
            Some(TableError::OtherPad),
            Some(TableError::NotATable),
        ];
        for value in [0, 3, 1 << 16, u32::MAX] {
            for (index, error) in errors.iter().enumerate() {
                let bytes = edited(8 + 4 * index, &value.to_le_bytes());
                assert_eq!(read(&bytes).err(), *error, "{value} as dimension {index}");
            }
        }
    }

    #[test]
    fn values_that_no_solver_gives_are_refused() {
        let table = ResponseTable::small();
        let basis = 8 + 6 * 4 + 8 + table.key.len();
        let terms = basis + 4 * table.basis.len();
        for at in [basis, terms] {
            for value in [f32::NAN, f32::INFINITY, -1e30] {
                let bytes = edited(at, &value.to_le_bytes());
                assert_eq!(read(&bytes), Err(TableError::OutOfRange), "{value} at {at}");
            }
        }
    }

    proptest! {
        #[test]
        fn every_flipped_bit_is_detected(at in 8..100_000usize, bit in 0..8u8) {
            static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
            let mut bytes = BYTES.get_or_init(|| of_rise().to_bytes()).clone();
            let at = at % bytes.len();
            bytes[at] ^= 1 << bit;
            prop_assert!(read(&bytes).is_err());
        }
    }
}
