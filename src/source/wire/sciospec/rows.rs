//! Rows of an instrument, and the frames that they form.

use std::sync::Arc;

use super::MEASURE;
use crate::pad::{Channel, Pair, Protocol};
use crate::source::wire::{Readings, Stamp, WireFrame};

/// Number of electrodes of a group, and so of potentials of a row.
const GROUP: usize = 16;
/// Number of electrodes of the largest instrument.
const MOST_ELECTRODES: usize = 32;
/// Lengths of a row's data: group, drive, time and potentials, with or without the row of the frequency stack.
pub(super) const ROW_BYTES: [usize; 2] = [7 + 8 * GROUP, 9 + 8 * GROUP];
/// Largest potential, V; the converter's range is 10 V. Bytes shifted by a loss soon exceed it.
const MOST_VOLTS: f32 = 20.0;
/// Number of drives of the longest sequence.
const MOST_DRIVES: usize = 64;
/// After this many interrupted cycles the cycle is learned again: the first one may have lacked a row.
const MOST_INTERRUPTIONS: u32 = 8;
/// The instrument's clock counts milliseconds.
const TICK_NS: u32 = 1_000_000;

/// The potentials of one group of electrodes under one drive.
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
    pub(super) fn parse(data: &[u8]) -> Result<Self, String> {
        let head = data.len() - 8 * GROUP;
        let group = usize::from(data[0]);
        let drive = Pair(usize::from(data[1]), usize::from(data[2]));
        let electrodes = 1..=MOST_ELECTRODES;
        if !(1..=MOST_ELECTRODES / GROUP).contains(&group) {
            return Err(format!("a row of the unknown channel group {group}"));
        }
        if !electrodes.contains(&drive.0) || !electrodes.contains(&drive.1) || drive.0 == drive.1 {
            return Err(format!(
                "a row driven between electrodes {} and {}",
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

/// Collects rows until they form a frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    rows: Vec<Row>,
    /// Group and drive of every row of a frame; empty until the first complete frame.
    cycle: Vec<(usize, Pair)>,
    /// The channel of each value.
    listing: Option<Arc<[Channel]>>,
    /// Rows are missing: no frame until the cycle starts again.
    is_interrupted: bool,
    /// How often rows were missing since the last frame.
    interruptions: u32,
    /// Whether the readings of a drive are handed up before their frame is complete.
    hands_up: bool,
}

/// What a row completes.
#[derive(Clone, Debug, Default)]
pub(super) struct AddedRow {
    /// The readings of its drive, if they are handed up.
    pub(super) readings: Option<Readings>,
    /// Its frame.
    pub(super) frame: Option<WireFrame>,
}

impl Rows {
    /// From now on the readings of each drive are handed up.
    pub(super) fn hand_up_readings(&mut self) {
        self.hands_up = true;
    }

    pub(super) fn hands_up(&self) -> bool {
        self.hands_up
    }

    /// Forgets the rows and the cycle.
    fn restart(&mut self) {
        *self = Self {
            hands_up: self.hands_up,
            ..Self::default()
        };
    }

    /// Adds a row.
    pub(super) fn add(&mut self, row: Row) -> Result<AddedRow, String> {
        let (drive, ms) = (row.drive, row.ms);
        let groups = self.cycle.iter().filter(|place| place.1 == drive).count();
        let ends_drive = row.group + 1 == groups;
        let frame = self.collect(row)?;
        let readings = (self.hands_up && ends_drive)
            .then(|| self.last_readings(&frame, drive, groups))
            .flatten();
        let readings = readings.map(|(first, values)| Readings {
            stamp: Some(stamp(ms)),
            ..Readings::from_values(first, values)
        });
        Ok(AddedRow { readings, frame })
    }

    /// The values of the drive that was added last, and the place of the first of them.
    fn last_readings(
        &self,
        frame: &Option<WireFrame>,
        drive: Pair,
        groups: usize,
    ) -> Option<(usize, Vec<f32>)> {
        match frame {
            Some(frame) => {
                let listing = frame.listing.as_ref()?;
                let first = listing.iter().position(|channel| channel.drive == drive)?;
                Some((first, frame.values[first..].to_vec()))
            }
            None => {
                let before = self.rows.len().checked_sub(groups)?;
                let (earlier, last) = self.rows.split_at(before);
                Some((values(earlier).count(), values(last).collect()))
            }
        }
    }

    fn collect(&mut self, row: Row) -> Result<Option<WireFrame>, String> {
        let position = (row.group, row.drive);
        if self.cycle.is_empty() {
            return self.learn(row, position);
        }
        if position == self.cycle[0] {
            let missing = !self.rows.is_empty() && !self.is_interrupted;
            self.rows.clear();
            self.is_interrupted = false;
            self.rows.push(row);
            let whole = (self.cycle.len() == 1).then(|| self.frame());
            return if missing {
                Err("a frame without its last rows".to_owned())
            } else {
                Ok(whole)
            };
        }
        if !self.cycle.contains(&position) {
            // The cycle was learned from a frame that lacked its end.
            self.restart();
            return Err("a drive that was not in the frames before".to_owned());
        }
        if self.is_interrupted || self.rows.is_empty() {
            return Ok(None);
        }
        if position != self.cycle[self.rows.len()] {
            let Pair(into, out) = row.drive;
            return Err(format!(
                "a row driven between electrodes {} and {} out of order",
                into + 1,
                out + 1
            ));
        }
        self.rows.push(row);
        Ok((self.rows.len() == self.cycle.len()).then(|| self.frame()))
    }

    /// Learns the cycle: the first frame is complete when its first row repeats.
    fn learn(&mut self, row: Row, position: (usize, Pair)) -> Result<Option<WireFrame>, String> {
        let position_of = |row: &Row| (row.group, row.drive);
        self.is_interrupted = false;
        let begins_again = self
            .rows
            .first()
            .is_some_and(|first| position_of(first) == position);
        if begins_again {
            let mut cycle: Vec<(usize, Pair)> = self.rows.iter().map(position_of).collect();
            // A frame starts with the first drive, wherever decoding started, so that the order of values is
            // always the same.
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

    /// Bytes were lost: drops the rows of the present cycle.
    pub(super) fn drop_cycle(&mut self) {
        self.is_interrupted = true;
        self.rows.clear();
        self.interruptions += 1;
        if self.interruptions == MOST_INTERRUPTIONS {
            self.restart();
        }
    }

    /// The frame of the collected rows, which are removed.
    fn frame(&mut self) -> WireFrame {
        self.interruptions = 0;
        let ticks = self.rows.first().map_or(0, |row| row.ms);
        let values = values(&self.rows).collect();
        self.rows.clear();
        WireFrame {
            values,
            sequence: None,
            stamp: Some(stamp(ticks)),
            listing: self.listing.clone(),
        }
    }

    pub(super) fn held_bytes(&self) -> usize {
        size_of_val(self.rows.as_slice()) + size_of_val(self.cycle.as_slice())
    }
}

fn stamp(ms: u32) -> Stamp {
    Stamp {
        ticks: ms,
        tick_ns: TICK_NS,
    }
}

/// The differences of the potentials of some rows.
fn values(rows: &[Row]) -> impl Iterator<Item = f32> + '_ {
    rows.chunk_by(|a, b| a.drive == b.drive).flat_map(|rows| {
        let potentials: Vec<f32> = rows.iter().flat_map(|row| row.potentials).collect();
        adjacent(rows[0].drive, potentials.len())
            .map(move |Channel { measure, .. }| potentials[measure.1] - potentials[measure.0])
    })
}

/// The channels of the values of a cycle.
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
            return Err("rows that form no frame: each drive needs all channel groups".to_owned());
        }
        channels.extend(adjacent(drive, electrodes));
    }
    Ok(channels.into())
}

/// The differences of neighbours without a driven electrode: the second potential minus the first.
fn adjacent(drive: Pair, electrodes: usize) -> impl Iterator<Item = Channel> {
    Protocol::pairs_with_step(electrodes, 1)
        .into_iter()
        .filter(move |measure| !drive.shares_electrode(*measure))
        .map(move |measure| Channel { drive, measure })
}

/// A row as the instrument sends it, with imaginary parts of zero and without the row of the frequency stack.
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
