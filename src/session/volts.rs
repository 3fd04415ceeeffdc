//! Frames of f32 voltages as bytes: as they are, or packed without loss.
//!
//! Packing: a float's bits, brought into the order of the numbers, are an integer; each channel's next integer is foretold from
//! its past, and what the foretelling missed by is written in a Rice code whose parameter follows the channel's misses. Noise
//! cannot be packed, and foretelling from a mean costs little more than the noise itself: session.csv takes 427 bytes a frame
//! of 208 channels, its noise alone 402 (`tests/recording_size.rs`).
//!
//! Integers only, so packer and unpacker agree on every machine. Invariant: every f32 comes back with its bits, whatever they
//! are, and a block that does not end in the right check sum is refused.

use crc::{CRC_32_ISO_HDLC, Crc};

/// No frame has more voltages: 64 electrodes' full table.
pub const MOST_CHANNELS: usize = 4096;
/// No block has more frames.
pub const MOST_FRAMES: usize = 64;

/// A block of plain little-endian f32.
const PLAIN: u8 = 0;
/// A packed block that stands alone: the number of channels, the first frame plain, the others foretold.
const FIRST: u8 = 1;
/// A packed block that goes on from the one before.
const NEXT: u8 = 2;

/// A miss whose quotient reaches this is written whole.
const ESCAPE: u32 = 24;
/// Fraction bits of running means.
const FRACTION: u32 = 4;
/// Shares of a new value in the three foretellers, as shifts: the last value, a short mean, a long one.
const SHARES: [u32; 3] = [0, 2, 4];
/// Share of a new miss in the mean that chooses among foretellers, as a shift ...
const CHOICE_SHARE: u32 = 2;
/// ... and in the one that the Rice parameter follows.
const SCALE_SHARE: u32 = 3;
/// Misses that a channel begins with: the noise of f32 readings at 60 dB.
const FIRST_MISS: i64 = 16_384;
static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes that are no block of frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a block of frames is damaged")]
pub struct DamagedVolts;

/// Frames as they are.
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
    finish(bytes, frames)
}

/// Packs blocks of frames, each foretold from those before.
#[derive(Debug, Default)]
pub struct Packer {
    past: Vec<Past>,
}

impl Packer {
    /// The next block stands alone.
    pub fn restart(&mut self) {
        self.past.clear();
    }

    /// A block.
    ///
    /// # Panics
    /// If the frames differ in length, or there is none.
    pub fn pack(&mut self, frames: &[&[f32]]) -> Vec<u8> {
        let channels = frames[0].len();
        let mut rest = frames;
        let mut bytes = Vec::new();
        if self.past.len() == channels {
            bytes.push(NEXT);
        } else {
            bytes.push(FIRST);
            bytes.extend_from_slice(&(channels as u16).to_le_bytes());
            push_plain(&mut bytes, frames[0]);
            self.past = frames[0].iter().map(|v| Past::new(ordered(*v))).collect();
            rest = &frames[1..];
        }
        let mut bits = BitWriter::new(bytes);
        for frame in rest {
            assert_eq!(frame.len(), channels, "frames of one pad");
            for (past, value) in self.past.iter_mut().zip(*frame) {
                let value = ordered(*value);
                let miss = value.wrapping_sub(past.foretold());
                bits.rice(zigzag(miss), past.parameter());
                past.learn(value, miss);
            }
        }
        finish(bits.finish(), frames)
    }
}

/// Undoes [`plain`] and [`Packer`].
#[derive(Debug, Default)]
pub struct Unpacker {
    past: Vec<Past>,
}

impl Unpacker {
    /// The frames of a block of so many.
    ///
    /// # Errors
    /// Bytes of something else, damaged ones, or a block whose predecessor is missing.
    pub fn unpack(&mut self, count: usize, bytes: &[u8]) -> Result<Vec<Vec<f32>>, DamagedVolts> {
        if count == 0 || count > MOST_FRAMES {
            return Err(DamagedVolts);
        }
        let (body, sum) = bytes.split_last_chunk::<4>().ok_or(DamagedVolts)?;
        let (kind, body) = body.split_first().ok_or(DamagedVolts)?;
        let frames = match *kind {
            PLAIN => {
                let channels = body.len() / 4 / count;
                if channels * 4 * count != body.len() || channels > MOST_CHANNELS {
                    return Err(DamagedVolts);
                }
                body.chunks_exact((4 * channels).max(1))
                    .map(take_plain)
                    .collect()
            }
            FIRST => {
                let (channels, body) = body.split_first_chunk::<2>().ok_or(DamagedVolts)?;
                let channels = usize::from(u16::from_le_bytes(*channels));
                if channels == 0 || channels > MOST_CHANNELS {
                    return Err(DamagedVolts);
                }
                let (first, body) = body.split_at_checked(4 * channels).ok_or(DamagedVolts)?;
                let first = take_plain(first);
                self.past = first.iter().map(|v| Past::new(ordered(*v))).collect();
                let mut frames = vec![first];
                self.rest(count - 1, body, &mut frames)?;
                frames
            }
            NEXT if !self.past.is_empty() => {
                let mut frames = Vec::new();
                self.rest(count, body, &mut frames)?;
                frames
            }
            _ => return Err(DamagedVolts),
        };
        if frames.len() == count
            && check_sum(frames.iter().map(Vec::as_slice)) == u32::from_le_bytes(*sum)
        {
            Ok(frames)
        } else {
            self.past.clear();
            Err(DamagedVolts)
        }
    }

    fn rest(
        &mut self,
        count: usize,
        body: &[u8],
        frames: &mut Vec<Vec<f32>>,
    ) -> Result<(), DamagedVolts> {
        let mut bits = BitReader::new(body);
        for _ in 0..count {
            let mut frame = Vec::with_capacity(self.past.len());
            for past in &mut self.past {
                let miss = unzigzag(bits.rice(past.parameter()).ok_or(DamagedVolts)?);
                let value = past.foretold().wrapping_add(miss);
                past.learn(value, miss);
                frame.push(f32::from_bits(unordered(value)));
            }
            frames.push(frame);
        }
        Ok(())
    }
}

/// What is known of a channel.
#[derive(Clone, Copy, Debug)]
struct Past {
    /// Running means of its values, each with [`FRACTION`] bits.
    means: [i64; 3],
    /// How much each of them missed by of late.
    misses: [i64; 3],
    /// How much the chosen one missed by.
    scale: i64,
    /// Values so far, up to 16: until then all means are plain ones.
    seen: i64,
}

impl Past {
    fn new(value: i32) -> Self {
        Self {
            means: [i64::from(value) << FRACTION; 3],
            misses: [FIRST_MISS << FRACTION; 3],
            scale: FIRST_MISS << FRACTION,
            seen: 1,
        }
    }

    fn foretold(&self) -> i32 {
        let [a, b, c] = self.misses;
        let best = if a < b && a < c {
            0
        } else if b < c {
            1
        } else {
            2
        };
        // A mean of i32 values is one.
        (self.means[best] >> FRACTION) as i32
    }

    /// The Rice parameter: a code of mean 2 |miss| is shortest near log2(1.6 |miss|).
    fn parameter(&self) -> u32 {
        let scaled = (self.scale * 13 / 8) >> FRACTION;
        scaled.max(1).ilog2().min(31)
    }

    fn learn(&mut self, value: i32, miss: i32) {
        let value = i64::from(value) << FRACTION;
        self.seen = (self.seen + 1).min(1 << SHARES[2]);
        for ((mean, missed), share) in self.means.iter_mut().zip(&mut self.misses).zip(SHARES) {
            let off = value - *mean;
            *missed += (off.abs() - *missed) >> CHOICE_SHARE;
            *mean += off / self.seen.min(1 << share);
        }
        let miss = i64::from(miss).abs() << FRACTION;
        self.scale += (miss - self.scale) >> SCALE_SHARE;
    }
}

/// A float's bits as an integer in the order of the numbers.
fn ordered(value: f32) -> i32 {
    let bits = value.to_bits() as i32;
    bits ^ (((bits >> 31) as u32) >> 1) as i32
}

fn unordered(value: i32) -> u32 {
    (value ^ (((value >> 31) as u32) >> 1) as i32) as u32
}

fn zigzag(value: i32) -> u32 {
    ((value << 1) ^ (value >> 31)) as u32
}

fn unzigzag(value: u32) -> i32 {
    ((value >> 1) as i32) ^ -((value & 1) as i32)
}

fn push_plain(bytes: &mut Vec<u8>, frame: &[f32]) {
    for value in frame {
        bytes.extend_from_slice(&value.to_bits().to_le_bytes());
    }
}

fn take_plain(bytes: &[u8]) -> Vec<f32> {
    let (values, _) = bytes.as_chunks::<4>();
    values
        .iter()
        .map(|v| f32::from_bits(u32::from_le_bytes(*v)))
        .collect()
}

fn finish(mut bytes: Vec<u8>, frames: &[&[f32]]) -> Vec<u8> {
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

/// Bits, the highest of a byte first.
struct BitWriter {
    bytes: Vec<u8>,
    pending: u64,
    count: u32,
}

impl BitWriter {
    fn new(bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            pending: 0,
            count: 0,
        }
    }

    /// The lowest `count` bits of a value, 32 at most.
    fn put(&mut self, value: u32, count: u32) {
        self.pending = (self.pending << count) | u64::from(value);
        self.count += count;
        while self.count >= 8 {
            self.count -= 8;
            self.bytes.push((self.pending >> self.count) as u8);
        }
        self.pending &= (1 << self.count) - 1;
    }

    /// The quotient by 2^parameter as ones and a zero, then the remainder.
    fn rice(&mut self, value: u32, parameter: u32) {
        let quotient = value >> parameter;
        if quotient >= ESCAPE {
            self.put((1 << ESCAPE) - 1, ESCAPE);
            self.put(value, 32);
        } else {
            self.put((1 << (quotient + 1)) - 2, quotient + 1);
            self.put(value & ((1 << parameter) - 1), parameter);
        }
    }

    fn finish(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.put(0, 8 - self.count);
        }
        self.bytes
    }
}

struct BitReader<'a> {
    bytes: &'a [u8],
    pending: u64,
    count: u32,
}

impl<'a> BitReader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            pending: 0,
            count: 0,
        }
    }

    /// So many bits, 32 at most.
    fn take(&mut self, count: u32) -> Option<u32> {
        while self.count < count {
            let (byte, rest) = self.bytes.split_first()?;
            self.bytes = rest;
            self.pending = (self.pending << 8) | u64::from(*byte);
            self.count += 8;
        }
        self.count -= count;
        let value = self.pending >> self.count;
        self.pending &= (1 << self.count) - 1;
        Some(value as u32)
    }

    fn rice(&mut self, parameter: u32) -> Option<u32> {
        let mut quotient = 0;
        while quotient < ESCAPE && self.take(1)? == 1 {
            quotient += 1;
        }
        if quotient == ESCAPE {
            return self.take(32);
        }
        let high = quotient.checked_shl(parameter)?;
        Some(high | self.take(parameter)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bits(frames: &[Vec<f32>]) -> Vec<Vec<u32>> {
        let bits = |frame: &Vec<f32>| frame.iter().map(|v| v.to_bits()).collect();
        frames.iter().map(bits).collect()
    }

    /// Any bits at all, and readings that lie near each other.
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
        fn every_bit_comes_back(blocks in blocks(), restart in any::<u8>()) {
            let (mut packer, mut unpacker) = (Packer::default(), Unpacker::default());
            for (index, block) in blocks.iter().enumerate() {
                let frames: Vec<&[f32]> = block.iter().map(Vec::as_slice).collect();
                if restart >> index & 1 == 1 {
                    packer.restart();
                }
                for bytes in [plain(&frames), packer.pack(&frames)] {
                    let back = unpacker.unpack(block.len(), &bytes).expect("sound");
                    prop_assert_eq!(bits(&back), bits(block));
                }
            }
        }

        #[test]
        fn no_flipped_bit_goes_unseen(blocks in blocks(), at in any::<usize>(), bit in 0..8u8) {
            let frames: Vec<&[f32]> = blocks[0].iter().map(Vec::as_slice).collect();
            let mut bytes = Packer::default().pack(&frames);
            let at = at % bytes.len();
            bytes[at] ^= 1 << bit;
            // The padding of the last byte is nobody's.
            if let Ok(back) = Unpacker::default().unpack(frames.len(), &bytes) {
                prop_assert_eq!(bits(&back), bits(&blocks[0]));
            }
        }

        #[test]
        fn any_bytes_are_refused_or_read(bytes in proptest::collection::vec(any::<u8>(), 0..200), count in 0..80usize) {
            let _ = Unpacker::default().unpack(count, &bytes);
        }
    }

    #[test]
    fn a_block_without_its_predecessor_is_refused() {
        let mut packer = Packer::default();
        packer.pack(&[&[1.0, 2.0]]);
        let next = packer.pack(&[&[1.0, 2.0]]);
        assert_eq!(Unpacker::default().unpack(1, &next), Err(DamagedVolts));
    }

    #[test]
    fn steady_readings_take_next_to_nothing() {
        let frame: Vec<f32> = (0..208).map(|c| 1.0 + c as f32).collect();
        let mut packer = Packer::default();
        let mut last = 0;
        for _ in 0..40 {
            last = packer.pack(&[frame.as_slice(); 16]).len();
        }
        // One bit a value.
        assert!(last < 16 * 208 / 8 + 10, "{last} bytes");
    }
}
