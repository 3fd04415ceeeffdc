//! Rows of an instrument, and the frames that they make.

use std::sync::Arc;

use super::MEASURE;
use crate::pad::{Channel, Pair, Protocol};
use crate::source::wire::{Stamp, WireFrame};

/// Electrodes of a group: what one row holds.
const GROUP: usize = 16;
/// Electrodes of the largest instrument.
const MOST_ELECTRODES: usize = 32;
/// A row's data: group, drive and time, then the potentials; the longer has the row of the frequency stack too.
pub(super) const ROW_BYTES: [usize; 2] = [7 + 8 * GROUP, 9 + 8 * GROUP];
/// No potential is larger, V: the converter's range is 10 V. What is shifted by a lost byte soon is.
const MOST_VOLTS: f32 = 20.0;
/// Drives of the longest sequence.
const MOST_DRIVES: usize = 64;
/// A cycle that fits no more so many times is learned anew: the first one may have lacked a row.
const MOST_SPOILT: u32 = 8;
/// The instrument's clock counts milliseconds.
const TICK_NS: u32 = 1_000_000;

/// What one drive gave in one group of electrodes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    /// From 0.
    group: usize,
    drive: Pair,
    ms: u32,
    /// Real parts, V.
    potentials: [f32; GROUP],
}

impl Row {
    pub(super) fn of(data: &[u8]) -> Result<Self, String> {
        let head = data.len() - 8 * GROUP;
        let group = usize::from(data[0]);
        let drive = Pair(usize::from(data[1]), usize::from(data[2]));
        let electrodes = 1..=MOST_ELECTRODES;
        if !(1..=MOST_ELECTRODES / GROUP).contains(&group) {
            return Err(format!("a row of the channel group {group}"));
        }
        if !electrodes.contains(&drive.0) || !electrodes.contains(&drive.1) || drive.0 == drive.1 {
            return Err(format!(
                "a row driven between the electrodes {} and {}",
                drive.0, drive.1
            ));
        }
        let be = |at: usize| [data[at], data[at + 1], data[at + 2], data[at + 3]];
        let mut potentials = [0.0; GROUP];
        for (index, potential) in potentials.iter_mut().enumerate() {
            let at = head + 8 * index;
            let [real, imaginary] = [at, at + 4].map(|at| f32::from_be_bytes(be(at)));
            if !(real.abs() <= MOST_VOLTS && imaginary.abs() <= MOST_VOLTS) {
                return Err(format!("a row with a potential of {real:e} V"));
            }
            *potential = real;
        }
        Ok(Self {
            group: group - 1,
            drive: Pair(drive.0 - 1, drive.1 - 1),
            ms: u32::from_be_bytes(be(head - 4)),
            potentials,
        })
    }
}

/// Rows on their way to a frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    rows: Vec<Row>,
    /// Group and drive of every row of a whole frame, as soon as one was seen.
    cycle: Vec<(usize, Pair)>,
    /// What each value is a reading of.
    listing: Option<Arc<[Channel]>>,
    /// Rows are missing: until the cycle begins again nothing is a frame.
    spoilt: bool,
    /// How often that was so since the last frame.
    spoilt_times: u32,
}

impl Rows {
    pub(super) fn take(&mut self, row: Row) -> Result<Option<WireFrame>, String> {
        let turn = (row.group, row.drive);
        if self.cycle.is_empty() {
            return self.learn(row, turn);
        }
        if turn == self.cycle[0] {
            let missing = !self.rows.is_empty() && !self.spoilt;
            self.rows.clear();
            self.spoilt = false;
            self.rows.push(row);
            let whole = (self.cycle.len() == 1).then(|| self.frame());
            return if missing {
                Err("a frame without its last rows".to_owned())
            } else {
                Ok(whole)
            };
        }
        if !self.cycle.contains(&turn) {
            // The cycle was learned from a frame that lacked its end.
            *self = Self::default();
            return Err("a drive that was not there before".to_owned());
        }
        if self.spoilt || self.rows.is_empty() {
            return Ok(None);
        }
        if turn != self.cycle[self.rows.len()] {
            let Pair(into, out) = row.drive;
            return Err(format!(
                "a row driven between the electrodes {} and {} out of its turn",
                into + 1,
                out + 1
            ));
        }
        self.rows.push(row);
        Ok((self.rows.len() == self.cycle.len()).then(|| self.frame()))
    }

    /// The first frame is whole when its first row comes again.
    fn learn(&mut self, row: Row, turn: (usize, Pair)) -> Result<Option<WireFrame>, String> {
        let turn_of = |row: &Row| (row.group, row.drive);
        self.spoilt = false;
        let begins_again = self
            .rows
            .first()
            .is_some_and(|first| turn_of(first) == turn);
        if begins_again {
            let mut cycle: Vec<(usize, Pair)> = self.rows.iter().map(turn_of).collect();
            // Wherever reading began, a frame begins with the first drive: its values never change their meaning.
            let first = (0..cycle.len()).min_by_key(|index| (cycle[*index].1, cycle[*index].0));
            let first = first.unwrap_or(0);
            cycle.rotate_left(first);
            self.listing = Some(listing(&cycle)?);
            self.cycle = cycle;
            if first > 0 {
                self.rows.clear();
                return Ok(None);
            }
            let frame = self.frame();
            self.rows.push(row);
            return Ok(Some(frame));
        }
        if self.rows.len() == MOST_DRIVES * MOST_ELECTRODES / GROUP {
            return Err(format!("more than {MOST_DRIVES} drives"));
        }
        self.rows.push(row);
        Ok(None)
    }

    /// Something was lost: the rows so far are no frame.
    pub(super) fn spoil(&mut self) {
        self.spoilt = true;
        self.rows.clear();
        self.spoilt_times += 1;
        if self.spoilt_times == MOST_SPOILT {
            *self = Self::default();
        }
    }

    /// The frame that the rows are; they are gone then.
    fn frame(&mut self) -> WireFrame {
        self.spoilt_times = 0;
        let ticks = self.rows.first().map_or(0, |row| row.ms);
        let mut values = Vec::with_capacity(self.listing.as_ref().map_or(0, |list| list.len()));
        for rows in self.rows.chunk_by(|a, b| a.drive == b.drive) {
            let potentials: Vec<f32> = rows.iter().flat_map(|row| row.potentials).collect();
            for Channel { measure, .. } in adjacent(rows[0].drive, potentials.len()) {
                values.push(potentials[measure.1] - potentials[measure.0]);
            }
        }
        self.rows.clear();
        WireFrame {
            values,
            sequence: None,
            stamp: Some(Stamp {
                ticks,
                tick_ns: TICK_NS,
            }),
            listing: self.listing.clone(),
        }
    }

    pub(super) fn held_bytes(&self) -> usize {
        size_of_val(self.rows.as_slice()) + size_of_val(self.cycle.as_slice())
    }
}

/// What the values of a cycle are readings of.
fn listing(cycle: &[(usize, Pair)]) -> Result<Arc<[Channel]>, String> {
    let mut channels = Vec::new();
    let mut groups = None;
    for rows in cycle.chunk_by(|a, b| a.1 == b.1) {
        let is_whole = rows.iter().enumerate().all(|(index, row)| row.0 == index);
        let electrodes = GROUP * rows.len();
        let drive = rows[0].1;
        if !is_whole
            || drive.0.max(drive.1) >= electrodes
            || *groups.get_or_insert(rows.len()) != rows.len()
        {
            return Err("rows that make no frame: each drive needs all channel groups".to_owned());
        }
        channels.extend(adjacent(drive, electrodes));
    }
    Ok(channels.into())
}

/// The differences of neighbours that a drive leaves: the second's potential minus the first's.
fn adjacent(drive: Pair, electrodes: usize) -> impl Iterator<Item = Channel> {
    Protocol::stepped(electrodes, 1)
        .into_iter()
        .filter(move |measure| !drive.meets(*measure))
        .map(move |measure| Channel { drive, measure })
}

/// A row as the instrument sends it, the imaginary parts zero, without the row of the frequency stack.
#[must_use]
pub fn encode_row(group: usize, drive: Pair, ms: u32, potentials: &[f32]) -> Vec<u8> {
    let mut row = vec![MEASURE, ROW_BYTES[0] as u8, group as u8 + 1];
    row.extend_from_slice(&[drive.0 as u8 + 1, drive.1 as u8 + 1]);
    row.extend_from_slice(&ms.to_be_bytes());
    for index in 0..GROUP {
        let potential = potentials.get(index).copied().unwrap_or(0.0);
        row.extend_from_slice(&potential.to_be_bytes());
        row.extend_from_slice(&[0; 4]);
    }
    row.push(MEASURE);
    row
}
