//! Sciospec's EIT instruments: frames `CT LEN data CT`, single-ended potentials of sixteen electrodes in each.
//!
//! The instrument is set up for the pad's drives and for endless single-ended frames; every command waits for its
//! acknowledgement (`18 01 83 18`). A reading comes drive by drive, in groups of sixteen electrodes; it is a frame when
//! each drive of the sequence has come in its turn with all its groups. What gelpad works with are differences of
//! neighbours, real parts, those left out that meet the drive.
//!
//! There is no check sum. A row counts only if it closes where its length says, names two electrodes, holds potentials that
//! the instrument can measure, and comes in its turn.

mod rows;

use std::collections::VecDeque;

use super::{Decoded, Dialect, FormatKind, SHOWN_BYTES, Wiring};
use crate::pad::Pair;
use crate::types::{NANOS_PER_MS, Nanos};
pub use rows::encode_row;
use rows::{ROW_BYTES, Row, Rows};

/// An answer that has not come after so long is not waited for.
const PATIENCE_NS: Nanos = 500 * NANOS_PER_MS;
/// Silence of a running measurement after which it is set up again.
const SILENCE_NS: Nanos = 3000 * NANOS_PER_MS;

/// What the instrument is asked for: frames a second, Hz of the current, and its amplitude, A.
const FRAMES_PER_S: f32 = 100.0;
const EXCITATION_HZ: f32 = 10_000.0;
const AMPLITUDE_A: f64 = 1e-3;

/// Command tags.
pub(in crate::source) const ACK: u8 = 0x18;
pub(in crate::source) const SET_UP: u8 = 0xb0;
const READ_BACK: u8 = 0xb1;
pub(in crate::source) const OUTPUT: u8 = 0xb2;
pub(in crate::source) const MEASURE: u8 = 0xb4;
/// What an acknowledgement says.
pub(in crate::source) const DONE: u8 = 0x83;
const REFUSED: [u8; 2] = [0x81, 0x82];

/// Starts and stops the measurement.
pub const START: &[u8] = &[MEASURE, 1, 1, MEASURE];
/// See [`START`].
pub const STOP: &[u8] = &[MEASURE, 1, 0, MEASURE];

/// Reads the format from bytes, sets the instrument up and starts it.
#[derive(Clone, Debug)]
pub struct Sciospec {
    wiring: Wiring,
    buffer: Vec<u8>,
    /// Bytes that fit nowhere, since the last thing that did.
    astray: Vec<u8>,
    rows: Rows,
    /// Commands that are still to be sent; none before the talk has begun.
    commands: Option<VecDeque<Vec<u8>>>,
    /// When the command on its way was sent.
    awaiting_since_ns: Option<Nanos>,
    heard_ns: Nanos,
}

impl Sciospec {
    /// An instrument on a pad that is wired so.
    #[must_use]
    pub fn new(wiring: &Wiring) -> Self {
        Self {
            wiring: wiring.clone(),
            buffer: Vec::new(),
            astray: Vec::new(),
            rows: Rows::default(),
            commands: None,
            awaiting_since_ns: None,
            heard_ns: 0,
        }
    }

    /// One that was set up and started by someone else: it is only read, until it falls silent.
    #[must_use]
    pub fn running(wiring: &Wiring) -> Self {
        Self {
            commands: Some(VecDeque::new()),
            ..Self::new(wiring)
        }
    }

    /// Takes what the bytes begin with; how many they were, none if more must come first.
    fn take(&mut self, bytes: &[u8], decoded: &mut Vec<Decoded>) -> Option<usize> {
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
            if self.astray.len() < SHOWN_BYTES {
                self.astray.push(tag);
            }
            return Some(1);
        }
        self.tell_strays(decoded);
        let data = &bytes[2..whole - 1];
        match tag {
            ACK => self.answered(data[0], decoded),
            MEASURE => match Row::of(data).and_then(|row| self.rows.take(row)) {
                Ok(Some(frame)) => decoded.push(Decoded::Frame(frame)),
                Ok(None) => {}
                Err(reason) => {
                    self.rows.spoil();
                    decoded.push(Decoded::garbled(reason, &bytes[..whole]));
                }
            },
            _ => {}
        }
        Some(whole)
    }

    fn answered(&mut self, answer: u8, decoded: &mut Vec<Decoded>) {
        if REFUSED.contains(&answer) {
            decoded.push(Decoded::Note(format!(
                "the instrument refused a command (answer {answer:02x}): it goes on as it is set up"
            )));
        }
        if answer == DONE || REFUSED.contains(&answer) {
            self.awaiting_since_ns = None;
        }
    }

    fn tell_strays(&mut self, decoded: &mut Vec<Decoded>) {
        if !self.astray.is_empty() {
            self.rows.spoil();
            let reason = "bytes between what is known: some were lost";
            decoded.push(Decoded::garbled(reason, &self.astray));
            self.astray.clear();
        }
    }
}

impl Dialect for Sciospec {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        if !bytes.is_empty() {
            self.heard_ns = now_ns;
        }
        let mut buffer = std::mem::take(&mut self.buffer);
        // In pieces, so that the buffer stays short, whatever is fed.
        for piece in bytes.chunks(1024) {
            buffer.extend_from_slice(piece);
            let mut taken = 0;
            while let Some(count) = self.take(&buffer[taken..], decoded) {
                taken += count;
            }
            buffer.drain(..taken);
        }
        self.buffer = buffer;
    }

    fn say(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        let since = |then: Nanos| now_ns.saturating_sub(then);
        if self
            .awaiting_since_ns
            .is_some_and(|sent| since(sent) < PATIENCE_NS)
        {
            return None;
        }
        self.awaiting_since_ns = None;
        let is_silent = since(self.heard_ns) >= SILENCE_NS;
        let wiring = &self.wiring;
        let commands = match &mut self.commands {
            Some(commands) if commands.is_empty() && is_silent => {
                self.heard_ns = now_ns;
                self.commands.insert(set_up(wiring))
            }
            Some(commands) => commands,
            None => self.commands.insert(set_up(wiring)),
        };
        let command = commands.pop_front()?;
        self.awaiting_since_ns = Some(now_ns);
        Some(command)
    }

    fn reopened(&mut self) {
        *self = Self::new(&self.wiring);
    }

    fn farewell(&self) -> &'static [u8] {
        STOP
    }

    fn held_bytes(&self) -> usize {
        self.buffer.len() + self.astray.len() + self.rows.held_bytes()
    }

    fn kind(&self) -> Option<FormatKind> {
        Some(FormatKind::Sciospec)
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
    // One frequency: from, to, how many, linear.
    let frequencies = [&hz[..], &hz[..], &[0, 1], &[0]].concat();
    let mut commands = VecDeque::from([
        STOP.to_vec(),
        // Back to the instrument's defaults: the sequence of drives below is added to what is there.
        vec![SET_UP, 1, 1, SET_UP],
        // Endless.
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
    // Rows name their drive and time, and no frequency.
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

    /// A frame of sixteen drives; potentials are whole numbers, so that their differences are exact.
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

    fn fed(board: &mut Sciospec, bytes: &[u8]) -> Vec<Decoded> {
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
        while let Some(command) = board.say(now_ns) {
            assert_eq!(board.say(now_ns), None, "not before the answer");
            sent.push(command);
            // Every other answer is lost: it is not waited for longer than half a second.
            if sent.len() % 2 == 0 {
                board.feed(now_ns, &[ACK, 1, DONE, ACK], &mut Vec::new());
            } else {
                now_ns += PATIENCE_NS;
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
        let told = fed(&mut board, &[ACK, 1, 0x81, ACK]);
        assert!(matches!(&told[..], [Decoded::Note(_)]), "{told:?}");
    }

    #[test]
    fn rows_become_frames_of_differences_of_neighbours() {
        let mut board = board();
        let mut bytes = vec![0x55, 0x00];
        for seed in 0..4 {
            bytes.extend(frame(seed));
        }
        let decoded = fed(&mut board, &bytes);
        let found = frames(&decoded);
        assert_eq!(
            found.len(),
            4,
            "the first one is told when the second begins"
        );
        for (seed, values) in found.iter().enumerate() {
            assert_eq!(values.len(), 208);
            // Drive 0 leaves the neighbours from (2, 3) on.
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
            "drive 1 begins behind itself"
        );
    }

    #[test]
    fn a_frame_without_a_row_or_with_a_shifted_one_is_none() {
        let mut board = board();
        let whole = frame(0);
        fed(&mut board, &[whole.clone(), whole.clone()].concat());
        let row = whole.len() / 16;
        let without_row = [&whole[..row * 3], &whole[row * 4..]].concat();
        let mut shifted = whole.clone();
        shifted.remove(row * 5 + 60);
        let mut bad_drive = whole.clone();
        bad_drive[row * 7 + 3] = 99;
        let mut bad_volt = whole.clone();
        bad_volt[row * 7 + 9] = 0x7f;
        for damaged in [without_row, shifted, bad_drive, bad_volt] {
            let decoded = fed(&mut board, &[damaged, whole.clone()].concat());
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
        let found = frames(&fed(&mut board, &[frame.clone(), frame].concat()));
        assert_eq!(found.len(), 2);
        assert_eq!(found[1].len(), 32 * 29);
        assert_eq!(found[1][13], 0.5 - 15.0, "across the groups");
    }
}
