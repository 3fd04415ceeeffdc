//! gelpad's own packets: COBS between zero bytes, with a check sum, a sequence number and the board's time.
//! docs/wire.md documents every byte; `wire/gelpad_wire.h` writes the format in C.
//!
//! ```text
//! 0  u8   version, 1
//! 1  u8   kind of the values: 1 f32, 2 i32
//! 2  u16  number n of values
//! 4  u32  sequence number, one more with each frame, overflows
//! 8  u32  time of the frame, us by the board's clock, overflows
//! 12      n values of 4 bytes
//! ..  u32 CRC-32 (ISO-HDLC, as of zlib) of all before
//! ```
//! A packet of version 2 holds some of a frame's values, those of a drive for instance, sent as soon as they are read: after the
//! time come the place of the first value in the frame and the frame's number of values, both u16, and then the n values.
//!
//! A packet of version 3 names the readings: n times the electrodes of drive and measurement, a byte each, in the order of the
//! frame. A board sends it at start-up and now and then.
//!
//! All numbers are little-endian. A packet with a wrong check sum is never a frame; decoding restarts after
//! the next zero byte.

use std::sync::Arc;

use crc::{CRC_32_ISO_HDLC, Crc};

use super::partial::{PartPacket, PartialFrame};
use super::{Decoded, Dialect, FEWEST_VALUES, MOST_VALUES, Readings, Stamp, WireFormat, WireFrame};
use crate::pad::{Channel, Pair};
use crate::types::Nanos;

/// Version of a packet that holds a frame, ...
const VERSION: u8 = 1;
/// ... of one that holds a part of it, ...
const PART_VERSION: u8 = 2;
/// ... and of one that names the readings of a frame.
const LISTING_VERSION: u8 = 3;
const HEAD_BYTES: usize = 12;
/// Bytes after the head in a packet of version 2: first value and number of values of the frame.
const PART_HEAD_BYTES: usize = 4;
const SUM_BYTES: usize = 4;
/// The longest encoded packet: one more byte for every 254.
const LONGEST_PACKET: usize =
    cobs::max_encoding_length(HEAD_BYTES + PART_HEAD_BYTES + 4 * MOST_VALUES + SUM_BYTES);
/// The board's clock counts microseconds.
const TICK_NS: u32 = 1000;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Type of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Values {
    /// Single-precision numbers.
    F32,
    /// Counts of a converter. Beyond 24 bits they are rounded to the nearest f32.
    I32,
}

/// Decoder of the format.
#[derive(Clone, Debug, Default)]
pub struct Gelpad {
    packet: Vec<u8>,
    overlong: bool,
    /// The frame that arrives in parts.
    partial: PartialFrame,
    hands_up: bool,
    /// The readings of a frame, if the board named them.
    listing: Option<Arc<[Channel]>>,
}

/// What a packet holds.
enum Packet {
    Frame(WireFrame),
    Part(PartPacket),
    Listing(Vec<Channel>),
}

impl Gelpad {
    fn end_packet(&mut self, decoded: &mut Vec<Decoded>) {
        if self.overlong {
            let reason =
                "a packet without an end: is this gelpad's format, and is the baud rate right?";
            decoded.push(Decoded::garbled(reason, &self.packet));
            return;
        }
        // Zeros between packets have no meaning.
        if self.packet.is_empty() {
            return;
        }
        // Decoding works in place, so the first bytes are copied to be shown.
        let mut start = [0; super::SHOWN_BYTES];
        let shown_len = self.packet.len().min(start.len());
        start[..shown_len].copy_from_slice(&self.packet[..shown_len]);
        let packet = cobs::decode_in_place(&mut self.packet)
            .map_err(|_| "a packet with wrong stuffing: bytes were lost".to_owned())
            .and_then(|length| parse_packet(&self.packet[..length]));
        let shown = &start[..shown_len];
        match packet {
            Ok(Packet::Frame(frame)) => decoded.push(self.with_listing(frame)),
            Ok(Packet::Part(part)) => self.add_part(part, shown, decoded),
            Ok(Packet::Listing(channels)) => self.listing = Some(channels.into()),
            Err(reason) => decoded.push(Decoded::garbled(reason, shown)),
        }
    }

    /// A frame with the names of its readings, if the board named as many.
    fn with_listing(&self, frame: WireFrame) -> Decoded {
        let listing = self.listing.clone();
        Decoded::Frame(WireFrame {
            listing: listing.filter(|names| names.len() == frame.values.len()),
            ..frame
        })
    }

    /// Adds a part to its frame.
    fn add_part(&mut self, part: PartPacket, shown: &[u8], decoded: &mut Vec<Decoded>) {
        let readings = self.hands_up.then(|| Readings {
            first: part.first,
            values: part.values.clone(),
            sequence: Some(part.sequence),
            stamp: Some(part.stamp),
        });
        let added = self.partial.add(part);
        if let Some(reason) = added.problem {
            decoded.push(Decoded::garbled(reason, shown));
        }
        if added.is_next {
            decoded.extend(readings.map(Decoded::Readings));
        }
        decoded.extend(added.frame.map(|frame| self.with_listing(frame)));
    }
}

impl Dialect for Gelpad {
    fn feed(&mut self, _: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        for piece in bytes.split_inclusive(|byte| *byte == 0) {
            let (body, ends) = match piece.split_last() {
                Some((0, body)) => (body, true),
                _ => (piece, false),
            };
            let room = LONGEST_PACKET - self.packet.len();
            self.overlong |= body.len() > room;
            self.packet.extend_from_slice(&body[..body.len().min(room)]);
            if ends {
                self.end_packet(decoded);
                self.packet.clear();
                self.overlong = false;
            }
        }
    }

    fn hand_up_readings(&mut self) {
        self.hands_up = true;
    }

    fn reopened(&mut self) {
        self.packet.clear();
        self.overlong = false;
        self.partial = PartialFrame::default();
        self.listing = None;
    }

    fn held_bytes(&self) -> usize {
        let listed = self.listing.as_deref().map_or(0, size_of_val::<[Channel]>);
        self.packet.len() + self.partial.held_bytes() + listed
    }

    fn kind(&self) -> Option<WireFormat> {
        Some(WireFormat::Gelpad)
    }
}

/// What a packet holds, or why it is none.
fn parse_packet(packet: &[u8]) -> Result<Packet, String> {
    let short = || format!("a packet of {} bytes", packet.len());
    let (body, sum) = packet.split_last_chunk::<SUM_BYTES>().ok_or_else(short)?;
    if CRC.checksum(body) != u32::from_le_bytes(*sum) {
        return Err(format!(
            "a packet of {} bytes with a wrong check sum",
            packet.len()
        ));
    }
    let (head, rest) = body.split_first_chunk::<HEAD_BYTES>().ok_or_else(short)?;
    let [version, kind, c0, c1, s0, s1, s2, s3, t0, t1, t2, t3] = *head;
    let count = usize::from(u16::from_le_bytes([c0, c1]));
    let sequence = u32::from_le_bytes([s0, s1, s2, s3]);
    let stamp = Stamp {
        ticks: u32::from_le_bytes([t0, t1, t2, t3]),
        tick_ns: TICK_NS,
    };
    match version {
        VERSION => Ok(Packet::Frame(WireFrame {
            values: parse_values(kind, count, FEWEST_VALUES, rest)?,
            sequence: Some(sequence),
            stamp: Some(stamp),
            listing: None,
        })),
        PART_VERSION => {
            let (place, rest) = rest
                .split_first_chunk::<PART_HEAD_BYTES>()
                .ok_or_else(short)?;
            let [f0, f1, n0, n1] = *place;
            let [first, total] = [[f0, f1], [n0, n1]].map(|b| usize::from(u16::from_le_bytes(b)));
            if first + count > total || !(FEWEST_VALUES..=MOST_VALUES).contains(&total) {
                return Err(format!(
                    "a packet with {count} values from the place {first} of a frame of {total}"
                ));
            }
            Ok(Packet::Part(PartPacket {
                first,
                total,
                values: parse_values(kind, count, 1, rest)?,
                sequence,
                stamp,
            }))
        }
        LISTING_VERSION => Ok(Packet::Listing(parse_listing(count, rest)?)),
        _ => Err(format!(
            "version {version} of the format; only versions up to {LISTING_VERSION} are supported: update gelpad"
        )),
    }
}

/// The readings that a packet names.
fn parse_listing(count: usize, bytes: &[u8]) -> Result<Vec<Channel>, String> {
    if bytes.len() != 4 * count || !(FEWEST_VALUES..=MOST_VALUES).contains(&count) {
        return Err(format!(
            "a packet that names {count} readings according to its header, in {} bytes",
            bytes.len()
        ));
    }
    let readings = bytes.as_chunks::<4>().0.iter();
    let channels = readings.map(|electrodes| {
        let [a, b, p, q] = electrodes.map(usize::from);
        Channel {
            drive: Pair(a, b),
            measure: Pair(p, q),
        }
    });
    let channels: Vec<Channel> = channels.collect();
    match channels
        .iter()
        .position(|c| c.drive.0 == c.drive.1 || c.measure.0 == c.measure.1)
    {
        Some(index) => Err(format!("reading {index} has an electrode twice")),
        None => Ok(channels),
    }
}

/// The values of a packet, at least `fewest`.
fn parse_values(kind: u8, count: usize, fewest: usize, bytes: &[u8]) -> Result<Vec<f32>, String> {
    if bytes.len() != 4 * count || !(fewest..=MOST_VALUES).contains(&count) {
        return Err(format!(
            "a packet with {count} values according to its header, but {} bytes of values",
            bytes.len()
        ));
    }
    let words = bytes.as_chunks::<4>().0.iter();
    let values: Vec<f32> = match kind {
        1 => words.map(|word| f32::from_le_bytes(*word)).collect(),
        2 => words.map(|word| i32::from_le_bytes(*word) as f32).collect(),
        _ => {
            return Err(format!("values of unknown type {kind}: 1 is f32, 2 is i32"));
        }
    };
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(format!("value {index} is {}", values[index])),
        None => Ok(values),
    }
}

/// A packet of a frame as a board sends it, including the closing zero. I32 rounds each value to a whole number.
#[must_use]
pub fn encode(kind: Values, sequence: u32, time_us: u32, values: &[f32]) -> Vec<u8> {
    let values = &values[..values.len().min(MOST_VALUES)];
    encode_packet(VERSION, kind, (sequence, time_us), &[], values)
}

/// A packet of the readings `part` of a frame, which were taken at `time_us`.
///
/// # Panics
/// If the frame has no such values.
#[must_use]
pub fn encode_part(
    kind: Values,
    sequence: u32,
    time_us: u32,
    values: &[f32],
    part: std::ops::Range<usize>,
) -> Vec<u8> {
    let place = [part.start, values.len()].map(|n| (n as u16).to_le_bytes());
    let head = (sequence, time_us);
    encode_packet(PART_VERSION, kind, head, &place.concat(), &values[part])
}

/// A packet that names the readings of a frame, in order. Electrodes are numbered by a byte.
#[must_use]
pub fn encode_listing(channels: &[Channel]) -> Vec<u8> {
    let channels = &channels[..channels.len().min(MOST_VALUES)];
    let mut packet = vec![LISTING_VERSION, 0];
    packet.extend_from_slice(&(channels.len() as u16).to_le_bytes());
    packet.resize(HEAD_BYTES, 0);
    for Channel { drive, measure } in channels {
        packet.extend([drive.0, drive.1, measure.0, measure.1].map(|electrode| electrode as u8));
    }
    finish_packet(packet)
}

fn encode_packet(
    version: u8,
    kind: Values,
    (sequence, time_us): (u32, u32),
    place: &[u8],
    values: &[f32],
) -> Vec<u8> {
    let mut packet = Vec::with_capacity(HEAD_BYTES + place.len() + 4 * values.len() + SUM_BYTES);
    packet.push(version);
    packet.push(match kind {
        Values::F32 => 1,
        Values::I32 => 2,
    });
    packet.extend_from_slice(&(values.len() as u16).to_le_bytes());
    packet.extend_from_slice(&sequence.to_le_bytes());
    packet.extend_from_slice(&time_us.to_le_bytes());
    packet.extend_from_slice(place);
    for value in values {
        packet.extend_from_slice(&match kind {
            Values::F32 => value.to_le_bytes(),
            Values::I32 => (libm::roundf(*value) as i32).to_le_bytes(),
        });
    }
    finish_packet(packet)
}

/// Adds the check sum, stuffing and the closing zero.
fn finish_packet(mut packet: Vec<u8>) -> Vec<u8> {
    packet.extend_from_slice(&CRC.checksum(&packet).to_le_bytes());
    let mut encoded = cobs::encode_vec(&packet);
    encoded.push(0);
    encoded
}

#[cfg(test)]
mod tests {
    use super::super::tests_support::{frames, reasons};
    use super::*;
    use proptest::prelude::*;

    fn decode_all(bytes: &[u8]) -> Vec<Decoded> {
        let mut decoded = Vec::new();
        Gelpad::default().feed(0, bytes, &mut decoded);
        decoded
    }

    /// docs/wire.md shows this packet.
    #[test]
    fn the_documented_packet_is_what_is_sent() {
        let packet = encode(Values::F32, 7, 1_000_000, &[1.0, 0.5, 0.25, -2.0, 0.0]);
        let hex: Vec<String> = packet.iter().map(|byte| format!("{byte:02x}")).collect();
        let documented = include_str!("../../../docs/wire.md");
        assert!(
            documented.contains(&hex.join(" ")),
            "docs/wire.md does not show {}",
            hex.join(" ")
        );
    }

    #[test]
    fn unsupported_packets_are_refused() {
        let error_of = |change: &dyn Fn(&mut Vec<u8>)| {
            let mut body = encode(Values::F32, 1, 2, &[1.0; 5]);
            body.pop();
            let mut packet = cobs::decode_vec(&body).expect("sound");
            packet.truncate(packet.len() - SUM_BYTES);
            change(&mut packet);
            packet.extend_from_slice(&CRC.checksum(&packet).to_le_bytes());
            let mut encoded = cobs::encode_vec(&packet);
            encoded.push(0);
            let decoded = decode_all(&encoded);
            assert!(frames(&decoded).is_empty());
            reasons(&decoded)[0].to_owned()
        };
        assert!(error_of(&|p| p[0] = 4).starts_with("version 4"));
        assert!(error_of(&|p| p[0] = 3).contains("has an electrode twice"));
        assert!(error_of(&|p| p[1] = 3).starts_with("values of unknown type 3"));
        assert!(error_of(&|p| p[2] = 6).starts_with("a packet with 6 values"));
        assert!(error_of(&|p| p[14..16].copy_from_slice(&[0xc0, 0x7f])).contains("value 0 is NaN"));
        assert!(error_of(&|p| p.truncate(3)).starts_with("a packet of 7 bytes"));
    }

    #[test]
    fn readings_are_named_until_the_board_is_opened_again() {
        let channels: Vec<Channel> = (0..6)
            .map(|k| Channel {
                drive: Pair(k, k + 1),
                measure: Pair(k + 3, k + 2),
            })
            .collect();
        let mut board = Gelpad::default();
        let mut decoded = Vec::new();
        board.feed(0, &encode_listing(&channels), &mut decoded);
        for count in [6, 7] {
            board.feed(
                0,
                &encode(Values::F32, 1, 2, &vec![0.5; count]),
                &mut decoded,
            );
        }
        board.reopened();
        board.feed(0, &encode(Values::F32, 3, 4, &[0.5; 6]), &mut decoded);
        let named: Vec<bool> = decoded
            .iter()
            .map(|item| match item {
                Decoded::Frame(frame) => frame.listing.as_deref() == Some(channels.as_slice()),
                _ => panic!("{item:?}"),
            })
            .collect();
        assert_eq!(named, [true, false, false]);
    }

    #[test]
    fn an_endless_packet_takes_bounded_memory() {
        let mut board = Gelpad::default();
        let mut decoded = Vec::new();
        for _ in 0..100 {
            board.feed(0, &[1; 4096], &mut decoded);
            assert!(board.held_bytes() <= LONGEST_PACKET);
        }
        board.feed(0, &[0], &mut decoded);
        board.feed(0, &encode(Values::I32, 1, 2, &[5.0; 5]), &mut decoded);
        assert_eq!(reasons(&decoded).len(), 1);
        assert_eq!(frames(&decoded), [vec![5.0; 5]]);
    }

    proptest! {
        #[test]
        fn decoding_restores_every_bit(
            values in proptest::collection::vec(proptest::num::f32::NORMAL | proptest::num::f32::ZERO, 5..300),
            sequence: u32,
            time_us: u32,
            cut in 1usize..40,
        ) {
            let packet = encode(Values::F32, sequence, time_us, &values);
            let mut decoded = Vec::new();
            let mut board = Gelpad::default();
            for piece in packet.chunks(cut) {
                board.feed(0, piece, &mut decoded);
            }
            prop_assert_eq!(decoded.len(), 1);
            let Decoded::Frame(frame) = &decoded[0] else { panic!("{decoded:?}") };
            let bits = |values: &[f32]| -> Vec<u32> { values.iter().map(|v| v.to_bits()).collect() };
            prop_assert_eq!(bits(&frame.values), bits(&values));
            prop_assert_eq!(frame.sequence, Some(sequence));
            prop_assert_eq!(frame.stamp, Some(Stamp { ticks: time_us, tick_ns: 1000 }));
        }

        #[test]
        fn a_damaged_packet_is_not_a_frame_and_the_next_is_one(
            flips in proptest::collection::vec((0usize..850, 0u8..8), 1..6),
            lost in proptest::collection::vec(0usize..850, 0..4),
        ) {
            let sound = encode(Values::F32, 9, 9, &[0.125; 208]);
            let mut damaged = sound.clone();
            for (byte, bit) in &flips {
                damaged[*byte] ^= 1 << bit;
            }
            for byte in lost {
                damaged.remove(byte.min(damaged.len() - 2));
            }
            prop_assume!(damaged != sound);
            let mut stream = damaged;
            stream.extend_from_slice(&sound);
            // If the closing zero is lost, the next packet is lost too, but the one after it is complete.
            stream.extend_from_slice(&sound);
            let found = frames(&decode_all(&stream));
            prop_assert!((1..=2).contains(&found.len()), "{} frames", found.len());
            prop_assert!(found.iter().all(|values| *values == vec![0.125; 208]));
        }
    }
}
