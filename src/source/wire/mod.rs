//! Wire formats, one a file. A dialect decodes bytes and says which commands the board needs; it does no IO.
//!
//! A dialect returns frames with as many values as the line, reply or packet has;
//! [`Arrangement`](super::Arrangement) decides how many a pad needs and in which order. What it cannot read
//! is reported and skipped, and does not affect the next complete frame.
//!
//! Invariant: a dialect never holds more than [`MOST_HELD_BYTES`], for any input.

mod auto;
mod early;
pub mod gelpad;
pub mod lines;
pub mod openeit;
mod partial;
pub mod request;
pub mod sciospec;
pub mod square;
#[cfg(test)]
mod tests_support;
mod text;

pub use auto::{Auto, LISTEN_NS};

use std::sync::Arc;

use crate::pad::{Channel, Pad, Pair, Protocol};
use crate::types::Nanos;

/// Number of values of the largest frame: real and imaginary part of all pairs of 32 electrodes.
pub const MOST_VALUES: usize = 2048;
/// Number of values of the smallest frame: a line with fewer is a message.
pub const FEWEST_VALUES: usize = 5;
/// Limit of the bytes that a dialect holds for incomplete frames.
pub const MOST_HELD_BYTES: usize = 256 * 1024;
/// Number of bytes of a garbled frame that are kept to be shown.
pub const SHOWN_BYTES: usize = 64;

/// A frame as the board sent it.
#[derive(Clone, Debug, PartialEq)]
pub struct WireFrame {
    /// The values, in the board's order.
    pub values: Vec<f32>,
    /// The board's count of frames, if it has one.
    pub sequence: Option<u32>,
    /// The board's own time, if it has one.
    pub stamp: Option<Stamp>,
    /// The channel of each value, if the board reports it.
    pub listing: Option<Arc<[Channel]>>,
}

impl WireFrame {
    /// A frame of a board that sends only values.
    #[must_use]
    pub fn from_values(values: Vec<f32>) -> Self {
        Self {
            values,
            sequence: None,
            stamp: None,
            listing: None,
        }
    }
}

/// Readings of a frame that has not arrived completely. The whole frame follows, unless it is garbled.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// The place of the first of them in the board's frame.
    pub first: usize,
    /// Consecutive values.
    pub values: Vec<f32>,
    /// The number of their frame, if the board counts frames.
    pub sequence: Option<u32>,
    /// When they were taken by the board's own clock, if it has one.
    pub stamp: Option<Stamp>,
}

impl Readings {
    /// Readings of a board that sends only values.
    #[must_use]
    pub fn from_values(first: usize, values: Vec<f32>) -> Self {
        Self {
            first,
            values,
            sequence: None,
            stamp: None,
        }
    }
}

/// A time by the board's clock, which overflows after 2^32 ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// Ticks.
    pub ticks: u32,
    /// Length of a tick, ns.
    pub tick_ns: u32,
}

/// A result of decoding.
#[derive(Clone, Debug, PartialEq)]
pub enum Decoded {
    /// A frame.
    Frame(WireFrame),
    /// Readings of a frame that is still arriving, see [`Dialect::hand_up_readings`].
    Readings(Readings),
    /// A garbled frame.
    Garbled {
        /// The reason.
        reason: String,
        /// Its first bytes, at most [`SHOWN_BYTES`].
        bytes: Vec<u8>,
    },
    /// A message for the player.
    Note(String),
}

impl Decoded {
    fn garbled(reason: impl Into<String>, bytes: &[u8]) -> Self {
        Self::Garbled {
            reason: reason.into(),
            bytes: bytes[..bytes.len().min(SHOWN_BYTES)].to_vec(),
        }
    }
}

/// The language of a board. Times are nanoseconds since the port was opened.
pub trait Dialect: Send {
    /// Decodes bytes as they arrive and appends the results.
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>);

    /// From now on, readings of frames that are still arriving are handed up too, where the format allows it.
    fn hand_up_readings(&mut self) {}

    /// A command that the board needs now. Called after every feed, and twenty times a second while nothing arrives.
    fn poll_command(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        let _ = now_ns;
        None
    }

    /// The port was opened again: incomplete frames are dropped, and the dialogue restarts.
    fn reopened(&mut self);

    /// The command to send before the port is closed.
    fn stop_command(&self) -> &'static [u8] {
        &[]
    }

    /// Number of bytes held for incomplete frames.
    fn held_bytes(&self) -> usize;

    /// The format, once it is known.
    fn kind(&self) -> Option<WireFormat>;
}

/// A wire format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WireFormat {
    /// gelpad's own packets.
    Gelpad,
    /// Sciospec's instruments.
    Sciospec,
    /// OpenEIT Spectra's text.
    OpenEit,
    /// A reply with one value a line to each request.
    Request,
    /// One line with all pairs for each frame.
    Square,
    /// One line of numbers for each frame.
    Lines,
}

impl WireFormat {
    /// All formats; those that are recognised most surely first.
    pub const ALL: [Self; 6] = [
        Self::Gelpad,
        Self::Sciospec,
        Self::OpenEit,
        Self::Request,
        Self::Square,
        Self::Lines,
    ];

    /// Its name for `--format`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gelpad => "gelpad",
            Self::Sciospec => "sciospec",
            Self::OpenEit => "openeit",
            Self::Request => "request",
            Self::Square => "square",
            Self::Lines => "lines",
        }
    }

    /// Its description, for people.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::Gelpad => "gelpad's own packets",
            Self::Sciospec => "Sciospec EIT16/32",
            Self::OpenEit => "OpenEIT Spectra's text",
            Self::Request => "a value a line and `Done` for each `D`",
            Self::Square => "N x N values a line",
            Self::Lines => "a line of numbers a frame",
        }
    }

    /// A dialect of this format. `wiring` is used to set up instruments that need it.
    #[must_use]
    pub fn dialect(self, wiring: &Wiring, complex: bool) -> Box<dyn Dialect> {
        match self {
            Self::Gelpad => Box::new(gelpad::Gelpad::default()),
            Self::Sciospec => Box::new(sciospec::Sciospec::new(wiring)),
            Self::OpenEit => Box::new(openeit::OpenEit::default()),
            Self::Request => Box::new(request::Request::default()),
            Self::Square => Box::new(square::Square::default()),
            Self::Lines => Box::new(lines::Lines::new(complex)),
        }
    }
}

/// How a pad is driven, to set up an instrument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// Number of electrodes.
    pub electrodes: usize,
    /// Drives, in the order of a frame.
    pub drives: Vec<Pair>,
}

impl Wiring {
    /// The wiring of a pad.
    #[must_use]
    pub fn from_pad(pad: &Pad) -> Self {
        let mut drives: Vec<Pair> = Vec::new();
        for channel in &pad.protocol.channels {
            if !drives.contains(&channel.drive) {
                drives.push(channel.drive);
            }
        }
        Self {
            electrodes: pad.protocol.electrodes,
            drives,
        }
    }

    /// All pairs of neighbours are driven.
    #[must_use]
    pub fn adjacent(electrodes: usize) -> Self {
        Self {
            electrodes,
            drives: Protocol::pairs_with_step(electrodes, 1),
        }
    }
}

/// The value of `--format`: a format and declarations about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FormatChoice {
    /// The format; none: it is detected.
    pub kind: Option<WireFormat>,
    /// Whether values are pairs of real and imaginary part (format `lines`).
    pub complex: bool,
    /// The order, if it is declared instead of recognised.
    pub order: Option<DeclaredOrder>,
    /// Whether frames are used only when they are complete, however long they take.
    pub whole: bool,
}

/// An order that the player declares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeclaredOrder {
    /// Each drive's measurements start after the drive.
    pub rotated: bool,
    /// All signs are inverted, as with swapped leads of the meter.
    pub flipped: bool,
}

impl FormatChoice {
    /// A dialect for a board on a pad with this wiring.
    #[must_use]
    pub fn dialect(&self, wiring: &Wiring) -> Box<dyn Dialect> {
        match self.kind {
            Some(kind) => kind.dialect(wiring, self.complex),
            None => Box::new(Auto::new(wiring.clone())),
        }
    }
}

impl From<WireFormat> for FormatChoice {
    fn from(kind: WireFormat) -> Self {
        Self {
            kind: Some(kind),
            ..Self::default()
        }
    }
}

impl std::fmt::Display for FormatChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.kind.map_or("auto", WireFormat::name))?;
        let order = self.order.unwrap_or_default();
        let words = [
            (self.complex, "complex"),
            (self.order == Some(DeclaredOrder::default()), "plain"),
            (order.rotated, "rotated"),
            (order.flipped, "flipped"),
            (self.whole, "whole"),
        ];
        let mut mark = ':';
        for (_, word) in words.into_iter().filter(|(is, _)| *is) {
            write!(f, "{mark}{word}")?;
            mark = ',';
        }
        Ok(())
    }
}

impl std::str::FromStr for FormatChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, words) = text.split_once(':').unwrap_or((text, ""));
        let kind = WireFormat::ALL.into_iter().find(|kind| kind.name() == name);
        if kind.is_none() && name != "auto" {
            let names: Vec<&str> = WireFormat::ALL.iter().map(|kind| kind.name()).collect();
            return Err(format!(
                "unknown format `{name}`: write auto, {}",
                names.join(", ")
            ));
        }
        let mut format = Self {
            kind,
            ..Self::default()
        };
        for word in words.split(',').filter(|word| !word.is_empty()) {
            let order = format.order.unwrap_or_default();
            match word {
                "complex" if kind == Some(WireFormat::Lines) => format.complex = true,
                "whole" => format.whole = true,
                "plain" => format.order = Some(order),
                "rotated" => {
                    format.order = Some(DeclaredOrder {
                        rotated: true,
                        ..order
                    });
                }
                "flipped" => {
                    format.order = Some(DeclaredOrder {
                        flipped: true,
                        ..order
                    });
                }
                _ => {
                    return Err(format!(
                        "`{word}` cannot be declared for {name}: write plain, rotated, flipped, whole, or lines:complex"
                    ));
                }
            }
        }
        Ok(format)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_format_is_displayed_as_it_is_parsed() {
        for text in [
            "auto",
            "gelpad",
            "lines:complex",
            "lines:complex,rotated",
            "request:plain",
            "square:rotated,flipped",
            "openeit:whole",
            "auto:flipped,whole",
        ] {
            assert_eq!(text.parse::<FormatChoice>().expect(text).to_string(), text);
        }
    }

    #[test]
    fn an_unknown_format_or_word_is_refused() {
        let message = "teensy".parse::<FormatChoice>().expect_err("unknown");
        assert_eq!(
            message,
            "unknown format `teensy`: write auto, gelpad, sciospec, openeit, request, square, lines"
        );
        let message = "openeit:complex"
            .parse::<FormatChoice>()
            .expect_err("not of it");
        assert!(
            message.starts_with("`complex` cannot be declared"),
            "{message}"
        );
    }
}
