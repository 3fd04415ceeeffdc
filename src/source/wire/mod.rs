//! Wire formats, one a file: dialects that are fed bytes, say what the board must be told, and do no IO.
//!
//! A dialect hands up every frame with as many values as the line, reply or packet held: how many a pad needs, and in
//! which order, is for [`Arrangement`](super::Arrangement) to tell. What it cannot read it says and skips; the next
//! whole frame is read as if nothing had been.
//!
//! Invariant: whatever bytes come, a dialect holds at most [`MOST_HELD_BYTES`].

mod auto;
pub mod gelpad;
pub mod lines;
pub mod openeit;
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

/// Values of the largest frame: real and imaginary part of all pairs of 32 electrodes.
pub const MOST_VALUES: usize = 2048;
/// Values of the smallest: a line with fewer is a message, not a frame.
pub const FEWEST_VALUES: usize = 5;
/// What a dialect holds at most of what has not become a frame yet.
pub const MOST_HELD_BYTES: usize = 256 * 1024;
/// Bytes of something unreadable that are kept to be shown.
pub const SHOWN_BYTES: usize = 64;

/// A frame as the board sent it.
#[derive(Clone, Debug, PartialEq)]
pub struct WireFrame {
    /// Its values, in the order of the board.
    pub values: Vec<f32>,
    /// The board's count of frames, where it has one.
    pub sequence: Option<u32>,
    /// The board's own time, where it has one.
    pub stamp: Option<Stamp>,
    /// What each value is a reading of, where the board says so.
    pub listing: Option<Arc<[Channel]>>,
}

impl WireFrame {
    /// A frame of a board that sends nothing but values.
    #[must_use]
    pub fn of(values: Vec<f32>) -> Self {
        Self {
            values,
            sequence: None,
            stamp: None,
            listing: None,
        }
    }
}

/// A time by the board's own clock, whose count runs over after 2^32 ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    /// Ticks.
    pub ticks: u32,
    /// Length of a tick, ns.
    pub tick_ns: u32,
}

/// What a dialect makes of the bytes so far.
#[derive(Clone, Debug, PartialEq)]
pub enum Decoded {
    /// A frame.
    Frame(WireFrame),
    /// Something that should have been a frame but is not.
    Garbled {
        /// Why.
        reason: String,
        /// How it begins: at most [`SHOWN_BYTES`].
        bytes: Vec<u8>,
    },
    /// Something that the player should know.
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

/// A board's way of talking. Times are nanoseconds since the port was opened.
pub trait Dialect: Send {
    /// Takes bytes as they come and appends what ends in them.
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>);

    /// What the board must be told now. Asked after every feed, and twenty times a second while nothing comes.
    fn say(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        let _ = now_ns;
        None
    }

    /// The port was opened anew: half a frame that was there is forgotten, and the talk begins again.
    fn reopened(&mut self);

    /// What the board is told before the port is closed.
    fn farewell(&self) -> &'static [u8] {
        &[]
    }

    /// Bytes held of what has not become a frame yet.
    fn held_bytes(&self) -> usize;

    /// The format that is spoken, as soon as it is known.
    fn kind(&self) -> Option<FormatKind>;
}

/// A wire format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FormatKind {
    /// gelpad's own packets.
    Gelpad,
    /// Sciospec's instruments.
    Sciospec,
    /// OpenEIT Spectra's text.
    OpenEit,
    /// A reply of a value a line to each request.
    Request,
    /// A line of all pairs.
    Square,
    /// A line a frame.
    Lines,
}

impl FormatKind {
    /// All of them; those that are told most surely first.
    pub const ALL: [Self; 6] = [
        Self::Gelpad,
        Self::Sciospec,
        Self::OpenEit,
        Self::Request,
        Self::Square,
        Self::Lines,
    ];

    /// What `--format` calls it.
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

    /// What people call it.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::Gelpad => "gelpad's own packets",
            Self::Sciospec => "Sciospec EIT16/32",
            Self::OpenEit => "OpenEIT Spectra's text",
            Self::Request => "a value a line and `Done` for each `D`",
            Self::Square => "N x N values a line",
            Self::Lines => "a line of numbers a frame",
        }
    }

    /// A dialect of this format. `wiring` is what an instrument that can be set up is set up for.
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

/// How a pad is driven: what an instrument that can be set up is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// Number of electrodes.
    pub electrodes: usize,
    /// Drives, in the order of a frame.
    pub drives: Vec<Pair>,
}

impl Wiring {
    /// What a pad needs.
    #[must_use]
    pub fn of_pad(pad: &Pad) -> Self {
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

    /// Neighbours drive, all round.
    #[must_use]
    pub fn adjacent(electrodes: usize) -> Self {
        Self {
            electrodes,
            drives: Protocol::stepped(electrodes, 1),
        }
    }
}

/// What `--format` says: a format, and what is declared about it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Format {
    /// The format; none: it is found out.
    pub kind: Option<FormatKind>,
    /// Whether values are pairs of real and imaginary part (of `lines`).
    pub complex: bool,
    /// The order, where it is declared instead of recognised.
    pub order: Option<DeclaredOrder>,
}

/// An order that the player declares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeclaredOrder {
    /// Each drive's measurements begin behind the drive.
    pub rotated: bool,
    /// The meter's leads are the other way round.
    pub flipped: bool,
}

impl Format {
    /// A dialect for a board on a pad that is wired so.
    #[must_use]
    pub fn dialect(&self, wiring: &Wiring) -> Box<dyn Dialect> {
        match self.kind {
            Some(kind) => kind.dialect(wiring, self.complex),
            None => Box::new(Auto::new(wiring.clone())),
        }
    }
}

impl From<FormatKind> for Format {
    fn from(kind: FormatKind) -> Self {
        Self {
            kind: Some(kind),
            ..Self::default()
        }
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.kind.map_or("auto", FormatKind::name))?;
        let order = self.order.unwrap_or_default();
        let words = [
            (self.complex, "complex"),
            (self.order == Some(DeclaredOrder::default()), "plain"),
            (order.rotated, "rotated"),
            (order.flipped, "flipped"),
        ];
        let mut mark = ':';
        for (_, word) in words.into_iter().filter(|(is, _)| *is) {
            write!(f, "{mark}{word}")?;
            mark = ',';
        }
        Ok(())
    }
}

impl std::str::FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, words) = text.split_once(':').unwrap_or((text, ""));
        let kind = FormatKind::ALL.into_iter().find(|kind| kind.name() == name);
        if kind.is_none() && name != "auto" {
            let names: Vec<&str> = FormatKind::ALL.iter().map(|kind| kind.name()).collect();
            return Err(format!("write auto, {}", names.join(", ")));
        }
        let mut format = Self {
            kind,
            ..Self::default()
        };
        for word in words.split(',').filter(|word| !word.is_empty()) {
            let order = format.order.unwrap_or_default();
            match word {
                "complex" if kind == Some(FormatKind::Lines) => format.complex = true,
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
                        "`{word}` is nothing that can be declared of {name}: write plain, rotated, flipped, or lines:complex"
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
    fn a_format_is_written_as_it_is_read() {
        for text in [
            "auto",
            "gelpad",
            "lines:complex",
            "lines:complex,rotated",
            "request:plain",
            "square:rotated,flipped",
        ] {
            assert_eq!(text.parse::<Format>().expect(text).to_string(), text);
        }
    }

    #[test]
    fn an_unknown_format_or_word_is_told() {
        let said = "teensy".parse::<Format>().expect_err("unknown");
        assert_eq!(
            said,
            "write auto, gelpad, sciospec, openeit, request, square, lines"
        );
        let said = "openeit:complex".parse::<Format>().expect_err("not of it");
        assert!(said.starts_with("`complex` is nothing"), "{said}");
    }
}
