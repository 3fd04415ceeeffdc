//! Listening to a port without playing: what a board sends, how fast, and what it is.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Write};
use std::time::Instant;

use serialport::SerialPort;

use super::{now, port};
use crate::eit::order::{Layout, Order, OrderError, recognise};
use crate::source::SourceError;
use crate::source::wire::{Decoded, Dialect, Format, FormatKind, SHOWN_BYTES, WireFrame, Wiring};
use crate::types::Nanos;

/// Electrodes of boards, the likeliest first.
const ELECTRODES: [usize; 3] = [16, 8, 32];
/// Frames whose median tells the order.
const ORDER_FRAMES: usize = 9;
/// From this frame on the rate is measured.
const SETTLED_FRAMES: u64 = 5;
/// Different numbers of values that are counted; more are noise.
const MOST_COUNTS: usize = 64;

/// What was heard so far.
#[derive(Clone, Debug, Default)]
pub struct Heard {
    /// Since the port was opened, ns.
    pub elapsed_ns: Nanos,
    /// Bytes.
    pub bytes: u64,
    /// How it began.
    pub first_bytes: Vec<u8>,
    /// Whole frames.
    pub frames: u64,
    /// Arrival of the last of the first [`SETTLED_FRAMES`] and of the last frame, ns.
    between_ns: Option<(Nanos, Nanos)>,
    /// How many frames had how many values.
    pub values: BTreeMap<usize, u64>,
    /// What should have been a frame and was none.
    pub garbled: u64,
    /// The first of these: when, why, and how it begins.
    pub first_garbled: Option<(Nanos, String, Vec<u8>)>,
    /// Frames that are missing by the board's count.
    pub missing: u64,
    /// Time between the first and the last frame by the board's clock, ns.
    pub device_ns: Option<u64>,
    /// The format, as soon as it is known.
    pub kind: Option<FormatKind>,
    /// What the dialects had to say.
    pub notes: Vec<String>,
    /// Smallest and largest value.
    pub range: Option<(f32, f32)>,
    /// The first frames, to tell the order from.
    first: Vec<WireFrame>,
    sequence: Option<u32>,
    ticks: Option<u32>,
}

impl Heard {
    /// Frames a second, once the first have come: those wait until their format is sure.
    #[must_use]
    pub fn frames_per_s(&self) -> Option<f64> {
        let (first, last) = self.between_ns?;
        (last > first)
            .then(|| (self.frames - SETTLED_FRAMES) as f64 / ((last - first) as f64 * 1e-9))
    }

    /// The number of values that most frames have.
    #[must_use]
    pub fn usual_values(&self) -> Option<usize> {
        let most = self.values.iter().max_by_key(|(_, frames)| **frames);
        most.map(|(values, _)| *values)
    }

    /// Number of electrodes and order of the readings, told from the first frames.
    #[must_use]
    pub fn order(&self) -> Option<(usize, Result<Order, OrderError>)> {
        let count = self.usual_values()?;
        let electrodes = ELECTRODES
            .into_iter()
            .find(|electrodes| Layout::of(count, *electrodes).is_some())?;
        let frames: Vec<&WireFrame> = self
            .first
            .iter()
            .filter(|frame| frame.values.len() == count)
            .collect();
        let median: Vec<f64> = (0..count)
            .map(|index| {
                let mut values: Vec<f32> = frames.iter().map(|frame| frame.values[index]).collect();
                values.sort_unstable_by(f32::total_cmp);
                values
                    .get(values.len() / 2)
                    .map_or(0.0, |value| f64::from(*value))
            })
            .collect();
        Some((electrodes, recognise(&median, electrodes)))
    }

    fn take(&mut self, now_ns: Nanos, decoded: Vec<Decoded>) {
        for one in decoded {
            match one {
                Decoded::Frame(frame) => self.frame(now_ns, frame),
                // The opening cuts what is under way.
                Decoded::Garbled { .. } if self.frames == 0 && self.kind.is_some() => {}
                Decoded::Garbled { reason, bytes } => {
                    self.garbled += 1;
                    self.first_garbled.get_or_insert((now_ns, reason, bytes));
                }
                Decoded::Note(text) => self.notes.push(text),
            }
        }
    }

    fn frame(&mut self, now_ns: Nanos, frame: WireFrame) {
        self.frames += 1;
        if self.frames >= SETTLED_FRAMES {
            let first_ns = self.between_ns.map_or(now_ns, |(first, _)| first);
            self.between_ns = Some((first_ns, now_ns));
        }
        let count = frame.values.len();
        if self.values.len() < MOST_COUNTS || self.values.contains_key(&count) {
            *self.values.entry(count).or_default() += 1;
        }
        if let (Some(before), Some(sequence)) = (self.sequence, frame.sequence) {
            let gap = sequence.wrapping_sub(before).wrapping_sub(1);
            // A count that went back is a board that began anew.
            self.missing += if gap < u32::MAX / 2 {
                u64::from(gap)
            } else {
                0
            };
        }
        self.sequence = frame.sequence;
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
pub struct Listener {
    path: String,
    device: Box<dyn SerialPort>,
    dialect: Box<dyn Dialect>,
    may_speak: bool,
    started: Instant,
    heard: Heard,
    buffer: Vec<u8>,
}

impl Listener {
    /// Opens a port. With `may_speak` the board is told what it must be told; else nothing is ever sent.
    ///
    /// # Errors
    /// A port that cannot be opened.
    pub fn open(
        path: &str,
        baud: u32,
        format: Format,
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
            heard: Heard {
                kind: format.kind,
                ..Heard::default()
            },
            buffer: vec![0; 4096],
        })
    }

    /// Listens for a twentieth of a second at most.
    ///
    /// # Errors
    /// A port that went away.
    pub fn listen(&mut self) -> Result<&Heard, SourceError> {
        let gone = || SourceError::Gone {
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
        let heard = &mut self.heard;
        heard.elapsed_ns = now_ns;
        heard.bytes += count as u64;
        let room = SHOWN_BYTES - heard.first_bytes.len();
        heard
            .first_bytes
            .extend_from_slice(&bytes[..count.min(room)]);
        let mut decoded = Vec::new();
        self.dialect.feed(now_ns, bytes, &mut decoded);
        heard.kind = self.dialect.kind().or(heard.kind);
        heard.take(now_ns, decoded);
        if self.may_speak
            && let Some(words) = self.dialect.say(now_ns)
        {
            // Whether it was heard shows in what comes.
            let _ = self.device.write_all(&words);
        }
        Ok(&self.heard)
    }

    /// What was heard so far.
    #[must_use]
    pub fn heard(&self) -> &Heard {
        &self.heard
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        if self.may_speak {
            let _ = self.device.write_all(self.dialect.farewell());
        }
    }
}
