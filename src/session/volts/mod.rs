//! Voltages of frames as bytes, lossless.
//!
//! Consecutive readings of a channel differ by noise, so their bits, taken as integers in the order of the numbers, are close
//! together. Each channel's next integer is predicted from its past, and the error of the prediction is written as a Rice
//! code whose parameter follows the channel's recent errors. Noise cannot be compressed, and predicting from a mean costs
//! little more than the noise: session.csv takes 427 bytes a frame of 208 channels, its noise alone 402. Readings that were
//! rounded (`--slim`) end in zero bits, which are left out.
//!
//! Invariant: every f32 is decoded with its exact bits, and a block with a wrong check sum is refused.

mod predictor;
mod rice;

use crc::{CRC_32_ISO_HDLC, Crc};

use predictor::Predictor;
use rice::{BitReader, BitWriter};

/// Most voltages of a frame: the full table of 64 electrodes.
pub const MOST_CHANNELS: usize = 4096;
/// Most frames of a block.
pub const MOST_FRAMES: usize = 64;

/// A block of plain little-endian f32.
const PLAIN: u8 = 0;
/// A packed block that stands alone: the number of channels, the first frame plain, the others predicted.
const FIRST: u8 = 1;
/// A packed block that continues the one before.
const NEXT: u8 = 2;
/// Like [`FIRST`], with the number of lowest bits of each channel that are left out, one byte each, before the first frame.
const ROUNDED: u8 = 3;
/// Most bits that are left out: those of the mantissa.
const MOST_SHIFT: u32 = 23;
/// Bits saved in each value that are worth a block that stands alone.
const WORTH_A_START: u32 = 2;
static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes that are not a block of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a block of frames is damaged")]
pub struct DamagedVolts;

/// A block of frames without compression.
///
/// # Panics
/// If the frames differ in length.
#[must_use]
pub fn plain(frames: &[&[f32]]) -> Vec<u8> {
    let mut bytes = vec![PLAIN];
    for frame in frames {
        assert_eq!(frame.len(), frames[0].len(), "frames of one pad");
        push_plain(&mut bytes, frame);
    }
    append_check_sum(bytes, frames)
}

/// Compresses blocks of frames, each predicted from those before.
#[derive(Debug, Default)]
pub struct VoltsEncoder {
    predictors: Vec<Predictor>,
    /// Number of lowest bits of each channel that are left out, all zero.
    shifts: Vec<u32>,
}

impl VoltsEncoder {
    /// Makes the next block stand alone.
    pub fn restart(&mut self) {
        self.predictors.clear();
    }

    /// Compresses a block.
    ///
    /// # Panics
    /// If the frames differ in length, or there is none.
    pub fn encode(&mut self, frames: &[&[f32]]) -> Vec<u8> {
        let channels = frames[0].len();
        let mut rest = frames;
        let mut bytes = Vec::new();
        let shifts = zero_bits(frames);
        let continues = self.predictors.len() == channels && self.fits(&shifts);
        if continues {
            bytes.push(NEXT);
        } else {
            self.shifts = shifts;
            let is_rounded = self.shifts.iter().any(|shift| *shift > 0);
            bytes.push(if is_rounded { ROUNDED } else { FIRST });
            bytes.extend_from_slice(&(channels as u16).to_le_bytes());
            if is_rounded {
                bytes.extend(self.shifts.iter().map(|shift| *shift as u8));
            }
            push_plain(&mut bytes, frames[0]);
            self.predictors = predictors(frames[0], &self.shifts);
            rest = &frames[1..];
        }
        let mut bits = BitWriter::new(bytes);
        for frame in rest {
            assert_eq!(frame.len(), channels, "frames of one pad");
            let channels = self.predictors.iter_mut().zip(&self.shifts);
            for ((predictor, shift), value) in channels.zip(*frame) {
                let value = ordered(*value) >> shift;
                let error = value.wrapping_sub(predictor.predicted());
                bits.put_rice(error, predictor.rice_parameter());
                predictor.update(value, error);
            }
        }
        append_check_sum(bits.finish(), frames)
    }

    /// Whether a block in which so many bits are zero continues the one before: what was left out is zero there too, and a new
    /// start would save little.
    fn fits(&self, zero_bits: &[u32]) -> bool {
        let sum = |shifts: &[u32]| shifts.iter().sum::<u32>();
        let mut channels = self.shifts.iter().zip(zero_bits);
        channels.all(|(left_out, zero)| left_out <= zero)
            && sum(zero_bits) <= sum(&self.shifts) + WORTH_A_START * zero_bits.len() as u32
    }
}

/// Decodes what [`plain`] and [`VoltsEncoder`] made.
#[derive(Debug, Default)]
pub struct VoltsDecoder {
    predictors: Vec<Predictor>,
    /// As in the encoder.
    shifts: Vec<u32>,
}

impl VoltsDecoder {
    /// The `count` frames of a block.
    ///
    /// # Errors
    /// Damaged or other bytes, or a block without the one that it continues.
    pub fn decode(&mut self, count: usize, bytes: &[u8]) -> Result<Vec<Vec<f32>>, DamagedVolts> {
        if count == 0 || count > MOST_FRAMES {
            return Err(DamagedVolts);
        }
        let (body, sum) = bytes.split_last_chunk::<4>().ok_or(DamagedVolts)?;
        let (kind, body) = body.split_first().ok_or(DamagedVolts)?;
        let frames = match *kind {
            PLAIN => decode_plain(count, body)?,
            FIRST => self.decode_first(count, body, false)?,
            ROUNDED => self.decode_first(count, body, true)?,
            NEXT if !self.predictors.is_empty() => {
                let mut frames = Vec::new();
                self.decode_predicted(count, body, &mut frames)?;
                frames
            }
            _ => return Err(DamagedVolts),
        };
        if frames.len() == count
            && check_sum(frames.iter().map(Vec::as_slice)) == u32::from_le_bytes(*sum)
        {
            Ok(frames)
        } else {
            self.predictors.clear();
            Err(DamagedVolts)
        }
    }

    fn decode_first(
        &mut self,
        count: usize,
        body: &[u8],
        is_rounded: bool,
    ) -> Result<Vec<Vec<f32>>, DamagedVolts> {
        let (channels, body) = body.split_first_chunk::<2>().ok_or(DamagedVolts)?;
        let channels = usize::from(u16::from_le_bytes(*channels));
        if channels == 0 || channels > MOST_CHANNELS {
            return Err(DamagedVolts);
        }
        let (shifts, body) = match is_rounded {
            true => body.split_at_checked(channels).ok_or(DamagedVolts)?,
            false => (&[][..], body),
        };
        let (first, body) = body.split_at_checked(4 * channels).ok_or(DamagedVolts)?;
        let first = read_plain(first);
        let mut shifts: Vec<u32> = shifts.iter().map(|shift| u32::from(*shift)).collect();
        shifts.resize(channels, 0);
        if shifts.iter().any(|shift| *shift > MOST_SHIFT) {
            return Err(DamagedVolts);
        }
        self.shifts = shifts;
        self.predictors = predictors(&first, &self.shifts);
        let mut frames = vec![first];
        self.decode_predicted(count - 1, body, &mut frames)?;
        Ok(frames)
    }

    fn decode_predicted(
        &mut self,
        count: usize,
        body: &[u8],
        frames: &mut Vec<Vec<f32>>,
    ) -> Result<(), DamagedVolts> {
        let mut bits = BitReader::new(body);
        for _ in 0..count {
            let mut frame = Vec::with_capacity(self.predictors.len());
            for (predictor, shift) in self.predictors.iter_mut().zip(&self.shifts) {
                let error = bits
                    .get_rice(predictor.rice_parameter())
                    .ok_or(DamagedVolts)?;
                let value = predictor.predicted().wrapping_add(error);
                predictor.update(value, error);
                frame.push(f32::from_bits(unordered(lengthened(value, *shift))));
            }
            frames.push(frame);
        }
        Ok(())
    }
}

fn decode_plain(count: usize, body: &[u8]) -> Result<Vec<Vec<f32>>, DamagedVolts> {
    let channels = body.len() / 4 / count;
    if channels * 4 * count != body.len() || channels > MOST_CHANNELS {
        return Err(DamagedVolts);
    }
    let frames = body.chunks_exact((4 * channels).max(1)).map(read_plain);
    Ok(frames.collect())
}

fn predictors(first: &[f32], shifts: &[u32]) -> Vec<Predictor> {
    let channels = first.iter().zip(shifts);
    channels
        .map(|(volt, shift)| Predictor::new(ordered(*volt) >> shift, *shift))
        .collect()
}

/// The number of lowest bits that are zero in all values of a channel, for each channel.
fn zero_bits(frames: &[&[f32]]) -> Vec<u32> {
    let mut least = vec![MOST_SHIFT; frames[0].len()];
    for frame in frames {
        for (least, volt) in least.iter_mut().zip(*frame) {
            *least = volt.to_bits().trailing_zeros().min(*least);
        }
    }
    least
}

/// The integer of a value from which the lowest bits, all zero, were left out.
fn lengthened(shortened: i32, shift: u32) -> i32 {
    // The bits of a negative value are inverted in its integer.
    let left_out = if shortened < 0 { (1 << shift) - 1 } else { 0 };
    (shortened << shift) | left_out
}

/// A float's bits as an integer in the order of the numbers.
fn ordered(value: f32) -> i32 {
    let bits = value.to_bits() as i32;
    bits ^ (((bits >> 31) as u32) >> 1) as i32
}

fn unordered(value: i32) -> u32 {
    (value ^ (((value >> 31) as u32) >> 1) as i32) as u32
}

fn push_plain(bytes: &mut Vec<u8>, frame: &[f32]) {
    for value in frame {
        bytes.extend_from_slice(&value.to_bits().to_le_bytes());
    }
}

fn read_plain(bytes: &[u8]) -> Vec<f32> {
    let (values, _) = bytes.as_chunks::<4>();
    values
        .iter()
        .map(|v| f32::from_bits(u32::from_le_bytes(*v)))
        .collect()
}

fn append_check_sum(mut bytes: Vec<u8>, frames: &[&[f32]]) -> Vec<u8> {
    let sum = check_sum(frames.iter().copied());
    bytes.extend_from_slice(&sum.to_le_bytes());
    bytes
}

/// CRC-32 of the frames' plain bytes.
fn check_sum<'a>(frames: impl Iterator<Item = &'a [f32]>) -> u32 {
    let mut digest = CRC.digest();
    for value in frames.flatten() {
        digest.update(&value.to_bits().to_le_bytes());
    }
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bits(frames: &[Vec<f32>]) -> Vec<Vec<u32>> {
        let bits = |frame: &Vec<f32>| frame.iter().map(|v| v.to_bits()).collect();
        frames.iter().map(bits).collect()
    }

    /// Arbitrary bits, and readings close to each other.
    fn values() -> impl Strategy<Value = u32> {
        let special = [
            0.0,
            -0.0,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
            f32::MIN_POSITIVE,
            f32::MAX,
        ];
        prop_oneof![
            any::<u32>(),
            (0..100_000u32).prop_map(|near| 1.25f32.to_bits() + near),
            // Rounded readings around zero.
            (-50..50i32).prop_map(|steps| (steps as f32 / 1024.0).to_bits()),
            proptest::sample::select(special.map(f32::to_bits).to_vec()),
        ]
    }

    fn blocks() -> impl Strategy<Value = Vec<Vec<Vec<f32>>>> {
        (1..6usize).prop_flat_map(|channels| {
            let frame = proptest::collection::vec(values().prop_map(f32::from_bits), channels);
            let block = proptest::collection::vec(frame, 1..20);
            proptest::collection::vec(block, 1..6)
        })
    }

    proptest! {
        #[test]
        fn every_bit_is_restored(blocks in blocks(), restart in any::<u8>()) {
            let (mut encoder, mut decoder) = (VoltsEncoder::default(), VoltsDecoder::default());
            for (index, block) in blocks.iter().enumerate() {
                let frames: Vec<&[f32]> = block.iter().map(Vec::as_slice).collect();
                if restart >> index & 1 == 1 {
                    encoder.restart();
                }
                for bytes in [plain(&frames), encoder.encode(&frames)] {
                    let back = decoder.decode(block.len(), &bytes).expect("sound");
                    prop_assert_eq!(bits(&back), bits(block));
                }
            }
        }

        #[test]
        fn every_flipped_bit_is_detected(blocks in blocks(), at in any::<usize>(), bit in 0..8u8) {
            let frames: Vec<&[f32]> = blocks[0].iter().map(Vec::as_slice).collect();
            let mut bytes = VoltsEncoder::default().encode(&frames);
            let at = at % bytes.len();
            bytes[at] ^= 1 << bit;
            // The padding of the last byte is not checked.
            if let Ok(back) = VoltsDecoder::default().decode(frames.len(), &bytes) {
                prop_assert_eq!(bits(&back), bits(&blocks[0]));
            }
        }

        #[test]
        fn any_bytes_are_refused_or_read(bytes in proptest::collection::vec(any::<u8>(), 0..200), count in 0..80usize) {
            let _ = VoltsDecoder::default().decode(count, &bytes);
        }
    }

    #[test]
    fn a_block_without_its_predecessor_is_refused() {
        let mut encoder = VoltsEncoder::default();
        encoder.encode(&[&[1.0, 2.0]]);
        let next = encoder.encode(&[&[1.0, 2.0]]);
        assert_eq!(VoltsDecoder::default().decode(1, &next), Err(DamagedVolts));
    }

    #[test]
    fn bits_that_are_zero_are_left_out_as_soon_as_there_are_some() {
        let mut encoder = VoltsEncoder::default();
        let mut lengths = Vec::new();
        for block in 0..8 {
            let frames: Vec<Vec<f32>> = (0..16)
                .map(|frame| {
                    let value = |c: usize| ((frame * 7 + c * 13 + block) % 8) as f32 / 1024.0;
                    let whole = |c| 1.0 + value(c) + if block == 0 { 1e-7 } else { 0.0 };
                    (0..50).map(whole).collect()
                })
                .collect();
            let frames: Vec<&[f32]> = frames.iter().map(Vec::as_slice).collect();
            lengths.push(encoder.encode(&frames).len());
        }
        assert!(lengths[7] * 3 < lengths[0], "{lengths:?}");
    }

    #[test]
    fn constant_readings_take_one_bit_each() {
        let frame: Vec<f32> = (0..208).map(|c| 1.0 + c as f32).collect();
        let mut encoder = VoltsEncoder::default();
        let mut last = 0;
        for _ in 0..40 {
            last = encoder.encode(&[frame.as_slice(); 16]).len();
        }
        assert!(last < 16 * 208 / 8 + 10, "{last} bytes");
    }
}
