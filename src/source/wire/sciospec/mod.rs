//! Sciospec's EIT instruments: messages `CT LEN data CT`, with single-ended potentials of sixteen electrodes in each.
//!
//! The instrument is set up for the pad's drives and for endless single-ended measurement; every command
//! waits for its acknowledgement (`18 01 83 18`). A measurement arrives drive by drive, in groups of sixteen
//! electrodes; it is a frame when each drive has arrived in its order with all groups. Values are the real
//! parts of the differences of neighbours, without those that include a driven electrode.
//!
//! There is no check sum. A row is valid only if it ends where its length says, names two electrodes, has
//! potentials that the instrument can measure, and arrives in its order.

mod rows;

use std::collections::VecDeque;

use super::{Decoded, Dialect, SHOWN_BYTES, WireFormat, Wiring};
use crate::pad::Pair;
use crate::types::{NANOS_PER_MS, Nanos};
pub use rows::encode_row;
use rows::{AddedRow, ROW_BYTES, Row, Rows};

/// Longest wait for an answer.
const ANSWER_NS: Nanos = 500 * NANOS_PER_MS;
/// Silence after which a running measurement is set up again.
const SILENCE_NS: Nanos = 3000 * NANOS_PER_MS;

/// Settings of the instrument: frame rate, 1/s, and frequency, Hz, and amplitude, A, of the current.
const FRAMES_PER_S: f32 = 100.0;
const EXCITATION_HZ: f32 = 10_000.0;
const AMPLITUDE_A: f64 = 1e-3;

/// Command tags.
pub(in crate::source) const ACK: u8 = 0x18;
pub(in crate::source) const SET_UP: u8 = 0xb0;
const READ_BACK: u8 = 0xb1;
pub(in crate::source) const OUTPUT: u8 = 0xb2;
pub(in crate::source) const MEASURE: u8 = 0xb4;
/// Contents of an acknowledgement.
pub(in crate::source) const DONE: u8 = 0x83;
const REFUSED: [u8; 2] = [0x81, 0x82];

/// Starts the measurement.
pub const START: &[u8] = &[MEASURE, 1, 1, MEASURE];
/// Stops the measurement.
pub const STOP: &[u8] = &[MEASURE, 1, 0, MEASURE];

/// Decoder of the format, which also sets up and starts the instrument.
#[derive(Clone, Debug)]
pub struct Sciospec {
    wiring: Wiring,
    buffer: Vec<u8>,
    /// Bytes since the last message that belong to none.
    stray_bytes: Vec<u8>,
    rows: Rows,
    /// Commands still to be sent; none before the dialogue has started.
    commands: Option<VecDeque<Vec<u8>>>,
    /// When the unanswered command was sent.
    awaiting_since_ns: Option<Nanos>,
    received_ns: Nanos,
}

impl Sciospec {
    /// An instrument on a pad with this wiring.
    #[must_use]
    pub fn new(wiring: &Wiring) -> Self {
        Self {
            wiring: wiring.clone(),
            buffer: Vec::new(),
            stray_bytes: Vec::new(),
            rows: Rows::default(),
            commands: None,
            awaiting_since_ns: None,
            received_ns: 0,
        }
    }

    /// An instrument that was already set up and started: it is only read, until it falls silent.
    #[must_use]
    pub fn running(wiring: &Wiring) -> Self {
        Self {
            commands: Some(VecDeque::new()),
            ..Self::new(wiring)
        }
    }

    /// Decodes the message at the start of the bytes; returns its length, or none if it is incomplete.
    fn take_message(&mut self, bytes: &[u8], decoded: &mut Vec<Decoded>) -> Option<usize> {
        let (tag, length) = (*bytes.first()?, usize::from(*bytes.get(1)?));
        let is_known = match tag {
            ACK => length == 1,
            MEASURE => ROW_BYTES.contains(&length),
            SET_UP | READ_BACK | OUTPUT => length > 0,
            _ => false,
        };
        let whole = length + 3;
        if is_known && bytes.len() < whole {
            return None;
        }
        if !is_known || bytes[whole - 1] != tag {
            if self.stray_bytes.len() < SHOWN_BYTES {
                self.stray_bytes.push(tag);
            }
            return Some(1);
        }
        self.report_strays(decoded);
        let data = &bytes[2..whole - 1];
        match tag {
            ACK => self.take_answer(data[0], decoded),
            MEASURE => match Row::parse(data).and_then(|row| self.rows.add(row)) {
                Ok(added) => {
                    let AddedRow { readings, frame } = added;
                    decoded.extend(readings.map(Decoded::Readings));
                    decoded.extend(frame.map(Decoded::Frame));
                }
                Err(reason) => {
                    self.rows.drop_cycle();
                    decoded.push(Decoded::garbled(reason, &bytes[..whole]));
                }
            },
            _ => {}
        }
        Some(whole)
    }

    fn take_answer(&mut self, answer: u8, decoded: &mut Vec<Decoded>) {
        if REFUSED.contains(&answer) {
            decoded.push(Decoded::Note(format!(
                "the instrument refused a command (answer {answer:02x}): it continues with its present settings"
            )));
        }
        if answer == DONE || REFUSED.contains(&answer) {
            self.awaiting_since_ns = None;
        }
    }

    fn report_strays(&mut self, decoded: &mut Vec<Decoded>) {
        if !self.stray_bytes.is_empty() {
            self.rows.drop_cycle();
            let reason = "unknown bytes between messages: bytes were lost";
            decoded.push(Decoded::garbled(reason, &self.stray_bytes));
            self.stray_bytes.clear();
        }
    }
}

impl Dialect for Sciospec {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        if !bytes.is_empty() {
            self.received_ns = now_ns;
        }
        let mut buffer = std::mem::take(&mut self.buffer);
        // In pieces, so that the buffer stays short.
        for piece in bytes.chunks(1024) {
            buffer.extend_from_slice(piece);
            let mut taken = 0;
            while let Some(count) = self.take_message(&buffer[taken..], decoded) {
                taken += count;
            }
            buffer.drain(..taken);
        }
        self.buffer = buffer;
    }

    fn poll_command(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        let since = |then: Nanos| now_ns.saturating_sub(then);
        if self
            .awaiting_since_ns
            .is_some_and(|sent| since(sent) < ANSWER_NS)
        {
            return None;
        }
        self.awaiting_since_ns = None;
        let is_silent = since(self.received_ns) >= SILENCE_NS;
        let wiring = &self.wiring;
        let commands = match &mut self.commands {
            Some(commands) if commands.is_empty() && is_silent => {
                self.received_ns = now_ns;
                self.commands.insert(set_up(wiring))
            }
            Some(commands) => commands,
            None => self.commands.insert(set_up(wiring)),
        };
        let command = commands.pop_front()?;
        self.awaiting_since_ns = Some(now_ns);
        Some(command)
    }

    fn hand_up_readings(&mut self) {
        self.rows.hand_up_readings();
    }

    fn reopened(&mut self) {
        let hands_up = self.rows.hands_up();
        *self = Self::new(&self.wiring);
        if hands_up {
            self.hand_up_readings();
        }
    }

    fn stop_command(&self) -> &'static [u8] {
        STOP
    }

    fn held_bytes(&self) -> usize {
        self.buffer.len() + self.stray_bytes.len() + self.rows.held_bytes()
    }

    fn kind(&self) -> Option<WireFormat> {
        Some(WireFormat::Sciospec)
    }
}

/// The commands that make an instrument send frames of a pad, in their order.
#[must_use]
pub fn set_up(wiring: &Wiring) -> VecDeque<Vec<u8>> {
    let command = |tag: u8, option: u8, data: &[u8]| {
        let mut bytes = vec![tag, data.len() as u8 + 1, option];
        bytes.extend_from_slice(data);
        bytes.push(tag);
        bytes
    };
    let hz = EXCITATION_HZ.to_be_bytes();
    // One frequency: start, end, count, linear scale.
    let frequencies = [&hz[..], &hz[..], &[0, 1], &[0]].concat();
    let mut commands = VecDeque::from([
        STOP.to_vec(),
        // Reset to the defaults: the drives below are added to those that are set.
        vec![SET_UP, 1, 1, SET_UP],
        // Endless measurement.
        command(SET_UP, 2, &[0, 0]),
        command(SET_UP, 3, &FRAMES_PER_S.to_be_bytes()),
        command(SET_UP, 4, &frequencies),
        command(SET_UP, 5, &AMPLITUDE_A.to_be_bytes()),
        // Single-ended, within a group.
        command(SET_UP, 8, &[1, 1]),
    ]);
    for Pair(into, out) in &wiring.drives {
        commands.push_back(command(SET_UP, 6, &[*into as u8 + 1, *out as u8 + 1]));
    }
    // Rows contain their drive and time, but no frequency.
    for (option, is_on) in [(1, 1), (2, 0), (3, 1)] {
        commands.push_back(command(OUTPUT, option, &[is_on]));
    }
    commands.push_back(START.to_vec());
    commands
}

#[cfg(test)]
mod tests {
    use super::super::Stamp;
    use super::super::tests_support::{frames, reasons};
    use super::*;

    /// A frame of sixteen drives; the potentials are integers, so that differences are exact.
    fn frame(seed: u32) -> Vec<u8> {
        (0..16)
            .flat_map(|drive| {
                let potentials: Vec<f32> = (0..16)
                    .map(|e| ((seed + 7 * drive + e * e) % 19) as f32 - 9.0)
                    .collect();
                let drive = Pair(drive as usize, (drive as usize + 1) % 16);
                encode_row(0, drive, 1000 + seed, &potentials)
            })
            .collect()
    }

    fn decode_all(board: &mut Sciospec, bytes: &[u8]) -> Vec<Decoded> {
        let mut decoded = Vec::new();
        board.feed(0, bytes, &mut decoded);
        decoded
    }

    fn board() -> Sciospec {
        Sciospec::new(&Wiring::adjacent(16))
    }

    #[test]
    fn every_command_waits_for_its_answer_and_starting_comes_last() {
        let mut board = board();
        let mut sent = Vec::new();
        let mut now_ns = 0;
        while let Some(command) = board.poll_command(now_ns) {
            assert_eq!(board.poll_command(now_ns), None, "not before the answer");
            sent.push(command);
            // Every other answer is lost: the next command follows after half a second.
            if sent.len() % 2 == 0 {
                board.feed(now_ns, &[ACK, 1, DONE, ACK], &mut Vec::new());
            } else {
                now_ns += ANSWER_NS;
            }
        }
        assert_eq!(sent[0], STOP);
        assert_eq!(sent[1], [0xb0, 1, 1, 0xb0]);
        assert!(
            sent.contains(&vec![0xb0, 3, 6, 1, 2, 0xb0]),
            "electrodes from 1"
        );
        assert!(sent.contains(&vec![0xb0, 3, 6, 16, 1, 0xb0]));
        assert!(sent.contains(&vec![0xb2, 2, 2, 0, 0xb2]));
        assert_eq!(sent.last().expect("some"), START);
        let noted = decode_all(&mut board, &[ACK, 1, 0x81, ACK]);
        assert!(matches!(&noted[..], [Decoded::Note(_)]), "{noted:?}");
    }

    #[test]
    fn rows_become_frames_of_differences_of_neighbours() {
        let mut board = board();
        let mut bytes = vec![0x55, 0x00];
        for seed in 0..4 {
            bytes.extend(frame(seed));
        }
        let decoded = decode_all(&mut board, &bytes);
        let found = frames(&decoded);
        assert_eq!(
            found.len(),
            4,
            "the first is complete when the second starts"
        );
        for (seed, values) in found.iter().enumerate() {
            assert_eq!(values.len(), 208);
            // The first difference without an electrode of drive 0 is (2, 3).
            let potential = |e: usize| ((seed + e * e) % 19) as f32 - 9.0;
            assert_eq!(values[0], potential(3) - potential(2));
        }
        let Some(Decoded::Frame(last)) = decoded.last() else {
            panic!("{decoded:?}")
        };
        assert_eq!(
            last.stamp,
            Some(Stamp {
                ticks: 1003,
                tick_ns: 1_000_000
            })
        );
        let listing = last.listing.as_ref().expect("drives are named");
        assert_eq!(
            listing[13].measure,
            Pair(3, 4),
            "the measurements of drive 1 start after it"
        );
    }

    #[test]
    fn a_frame_with_a_missing_or_shifted_row_is_dropped() {
        let mut board = board();
        let whole = frame(0);
        decode_all(&mut board, &[whole.clone(), whole.clone()].concat());
        let row = whole.len() / 16;
        let without_row = [&whole[..row * 3], &whole[row * 4..]].concat();
        let mut shifted = whole.clone();
        shifted.remove(row * 5 + 60);
        let mut bad_drive = whole.clone();
        bad_drive[row * 7 + 3] = 99;
        let mut bad_volt = whole.clone();
        bad_volt[row * 7 + 9] = 0x7f;
        for damaged in [without_row, shifted, bad_drive, bad_volt] {
            let decoded = decode_all(&mut board, &[damaged, whole.clone()].concat());
            assert_eq!(frames(&decoded).len(), 1, "{decoded:?}");
            assert!(!reasons(&decoded).is_empty());
        }
    }

    #[test]
    fn thirty_two_electrodes_come_in_two_groups() {
        let mut board = Sciospec::new(&Wiring::adjacent(32));
        let frame: Vec<u8> = (0..32)
            .flat_map(|drive| {
                (0..2).flat_map(move |group| {
                    let potentials: Vec<f32> =
                        (0..16).map(|e| e as f32 + 0.5 * group as f32).collect();
                    encode_row(group, Pair(drive, (drive + 1) % 32), 5, &potentials)
                })
            })
            .collect();
        let found = frames(&decode_all(&mut board, &[frame.clone(), frame].concat()));
        assert_eq!(found.len(), 2);
        assert_eq!(found[1].len(), 32 * 29);
        assert_eq!(found[1][13], 0.5 - 15.0, "across the groups");
    }
}
