//! Listens to a port without playing: what a board sends, how fast, in which format.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Write};
use std::time::Instant;

use serialport::SerialPort;

use super::port;
use super::sequence::{Place, Sequence};
use crate::eit::order::{Layout, Order, OrderError, recognise_order};
use crate::source::SourceError;
use crate::source::clock::now;
use crate::source::leading::leading_columns;
use crate::source::wire::{
    Decoded, Dialect, FormatChoice, SHOWN_BYTES, WireFormat, WireFrame, Wiring,
};
use crate::types::Nanos;

/// Numbers of electrodes of boards, the most common first.
const ELECTRODES: [usize; 3] = [16, 8, 32];
/// Number of frames whose median tells the order.
const ORDER_FRAMES: usize = 9;
/// The frame rate is measured from this frame on.
const SETTLED_FRAMES: u64 = 5;
/// Limit of different numbers of values that are counted; more are noise.
const MOST_COUNTS: usize = 64;

/// What the board has sent so far.
#[derive(Clone, Debug, Default)]
pub struct PortReport {
    /// Time since the port was opened, ns.
    pub elapsed_ns: Nanos,
    /// Number of bytes.
    pub bytes: u64,
    /// The first bytes.
    pub first_bytes: Vec<u8>,
    /// Number of complete frames.
    pub frames: u64,
    /// Arrival of frame number [`SETTLED_FRAMES`] and of the last frame, ns.
    between_ns: Option<(Nanos, Nanos)>,
    /// Number of frames for each number of values.
    pub values: BTreeMap<usize, u64>,
    /// Number of garbled frames.
    pub garbled: u64,
    /// The first garbled frame: time, reason, first bytes.
    pub first_garbled: Option<(Nanos, String, Vec<u8>)>,
    /// Frames that are missing according to the board's count.
    pub missing: u64,
    /// Time between the first and the last frame by the board's clock, ns.
    pub device_ns: Option<u64>,
    /// The format, once it is known.
    pub kind: Option<WireFormat>,
    /// Notes of the dialects.
    pub notes: Vec<String>,
    /// Smallest and largest value.
    pub range: Option<(f32, f32)>,
    /// The first frames, from which the order is recognised.
    first: Vec<WireFrame>,
    /// Late and repeated frames according to the board's count.
    pub late: u64,
    /// Frames that repeat the one before bit for bit.
    pub repeated: u64,
    sequence: Sequence,
    last_values: Vec<f32>,
    ticks: Option<u32>,
}

impl PortReport {
    /// Frames a second; none during the first frames, which are delayed until their format is sure.
    #[must_use]
    pub fn frames_per_s(&self) -> Option<f64> {
        let (first, last) = self.between_ns?;
        (last > first)
            .then(|| (self.frames - SETTLED_FRAMES) as f64 / ((last - first) as f64 * 1e-9))
    }

    /// The most common number of values.
    #[must_use]
    pub fn most_common_count(&self) -> Option<usize> {
        let most = self.values.iter().max_by_key(|(_, frames)| **frames);
        most.map(|(values, _)| *values)
    }

    /// Number of columns before the readings: a counter, a time.
    #[must_use]
    pub fn leading(&self) -> usize {
        let Some(count) = self.most_common_count() else {
            return 0;
        };
        let first = self.first.iter().map(|frame| frame.values.as_slice());
        let frames = first.filter(|values| values.len() == count);
        let is_layout = |count| {
            let mut electrodes = ELECTRODES.into_iter();
            electrodes.any(|electrodes| Layout::from_count(count, electrodes).is_some())
        };
        leading_columns(frames, is_layout).unwrap_or(0)
    }

    /// Number of readings of most frames.
    #[must_use]
    pub fn readings(&self) -> Option<usize> {
        self.most_common_count()?.checked_sub(self.leading())
    }

    /// Number of electrodes and order of the readings, recognised from the first frames.
    #[must_use]
    pub fn order(&self) -> Option<(usize, Result<Order, OrderError>)> {
        let leading = self.leading();
        let count = self.most_common_count()?.checked_sub(leading)?;
        let electrodes = ELECTRODES
            .into_iter()
            .find(|electrodes| Layout::from_count(count, *electrodes).is_some())?;
        let frames: Vec<&WireFrame> = self
            .first
            .iter()
            .filter(|frame| frame.values.len() == leading + count)
            .collect();
        let median: Vec<f64> = (0..count)
            .map(|index| {
                let values = frames.iter().map(|frame| frame.values[leading + index]);
                let mut values: Vec<f32> = values.collect();
                values.sort_unstable_by(f32::total_cmp);
                values
                    .get(values.len() / 2)
                    .map_or(0.0, |value| f64::from(*value))
            })
            .collect();
        Some((electrodes, recognise_order(&median, electrodes)))
    }

    fn take_decoded(&mut self, now_ns: Nanos, decoded: Vec<Decoded>) {
        for one in decoded {
            match one {
                Decoded::Frame(frame) => self.take_frame(now_ns, frame),
                // Their frame follows.
                Decoded::Readings(_) => {}
                // Opening the port cuts the first frame.
                Decoded::Garbled { .. } if self.frames == 0 && self.kind.is_some() => {}
                Decoded::Garbled { reason, bytes } => {
                    self.garbled += 1;
                    self.first_garbled.get_or_insert((now_ns, reason, bytes));
                }
                Decoded::Note(text) => self.notes.push(text),
            }
        }
    }

    fn take_frame(&mut self, now_ns: Nanos, frame: WireFrame) {
        self.frames += 1;
        if self.frames >= SETTLED_FRAMES {
            let first_ns = self.between_ns.map_or(now_ns, |(first, _)| first);
            self.between_ns = Some((first_ns, now_ns));
        }
        let count = frame.values.len();
        if self.values.len() < MOST_COUNTS || self.values.contains_key(&count) {
            *self.values.entry(count).or_default() += 1;
        }
        match self.sequence.take_number(frame.sequence) {
            Place::New { missing } => self.missing += u64::from(missing),
            Place::Older => {
                self.late += 1;
                return;
            }
        }
        self.repeated += u64::from(self.last_values == frame.values);
        self.last_values.clone_from(&frame.values);
        if let Some(stamp) = frame.stamp {
            let step = self
                .ticks
                .map_or(0, |before| stamp.ticks.wrapping_sub(before));
            let elapsed = u64::from(step) * u64::from(stamp.tick_ns);
            self.device_ns = Some(self.device_ns.unwrap_or(0) + elapsed);
            self.ticks = Some(stamp.ticks);
        }
        for value in &frame.values {
            let (least, most) = self.range.unwrap_or((*value, *value));
            self.range = Some((least.min(*value), most.max(*value)));
        }
        if self.first.len() < ORDER_FRAMES {
            self.first.push(frame);
        }
    }
}

/// A port that is listened to.
pub struct PortListener {
    path: String,
    device: Box<dyn SerialPort>,
    dialect: Box<dyn Dialect>,
    may_speak: bool,
    started: Instant,
    report: PortReport,
    buffer: Vec<u8>,
}

impl PortListener {
    /// Opens a port. Commands are sent to the board only with `may_speak`.
    ///
    /// # Errors
    /// The port cannot be opened.
    pub fn open(
        path: &str,
        baud: u32,
        format: FormatChoice,
        may_speak: bool,
    ) -> Result<Self, SourceError> {
        let device = port::open(path, baud).map_err(|error| SourceError::Open {
            port: path.to_owned(),
            error,
        })?;
        Ok(Self {
            path: path.to_owned(),
            device,
            dialect: format.dialect(&Wiring::adjacent(ELECTRODES[0])),
            may_speak,
            started: now(),
            report: PortReport {
                kind: format.kind,
                ..PortReport::default()
            },
            buffer: vec![0; 4096],
        })
    }

    /// Reads for at most 50 ms.
    ///
    /// # Errors
    /// The port has disappeared.
    pub fn listen(&mut self) -> Result<&PortReport, SourceError> {
        let gone = || SourceError::Disconnected {
            port: self.path.clone(),
        };
        let count = match self.device.read(&mut self.buffer) {
            Ok(0) => return Err(gone()),
            Ok(count) => count,
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted => 0,
                _ => return Err(gone()),
            },
        };
        let now_ns = Nanos::try_from(self.started.elapsed().as_nanos()).unwrap_or(Nanos::MAX);
        let bytes = &self.buffer[..count];
        let heard = &mut self.report;
        heard.elapsed_ns = now_ns;
        heard.bytes += count as u64;
        let room = SHOWN_BYTES - heard.first_bytes.len();
        heard
            .first_bytes
            .extend_from_slice(&bytes[..count.min(room)]);
        let mut decoded = Vec::new();
        self.dialect.feed(now_ns, bytes, &mut decoded);
        heard.kind = self.dialect.kind().or(heard.kind);
        heard.take_decoded(now_ns, decoded);
        if self.may_speak
            && let Some(command) = self.dialect.poll_command(now_ns)
        {
            // The answer will show whether it was received.
            let _ = self.device.write_all(&command);
        }
        Ok(&self.report)
    }

    /// What was heard so far.
    #[must_use]
    pub fn report(&self) -> &PortReport {
        &self.report
    }
}

impl Drop for PortListener {
    fn drop(&mut self) {
        if self.may_speak {
            let _ = self.device.write_all(self.dialect.stop_command());
        }
    }
}
