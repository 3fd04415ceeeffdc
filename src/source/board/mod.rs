//! A simulated board: measures a pad's voltages and speaks to the host, in every wire format.
//!
//! It is part of the library because tests, demonstrations and developers of firmware share it. The board
//! itself does no IO and reads no clock; [`serve()`] connects it to a pseudo-terminal and the clock.

mod faults;
mod firmware;
mod line;
mod serve;
mod signal;

pub use faults::{CableFaults, FaultyCable, RepeatedFault};
pub use serve::{ServePlan, ServeReport, serve};
pub use signal::{BoardSignal, LostElectrode};

use crate::eit::order::Layout;
use crate::pad::{Pad, Protocol};
use crate::source::wire::{WireFormat, Wiring};
use firmware::Firmware;

/// Settings of a simulated board.
#[derive(Clone, Copy, Debug)]
pub struct BoardSettings {
    /// Its wire format.
    pub kind: WireFormat,
    /// Whether values are pairs of real and imaginary part (format `lines`).
    pub complex: bool,
    /// The layout of its readings; none: the pad's channels in the pad's order.
    pub layout: Option<Layout>,
    /// Whether each drive's measurements start after the drive.
    pub rotated: bool,
    /// Whether the signs are inverted, as with swapped leads of the meter.
    pub flipped: bool,
    /// Whether values are counts of a converter (format `gelpad`).
    pub counts: bool,
    /// Whether the readings of each drive are a packet of their own (format `gelpad`).
    pub by_drive: bool,
    /// Whether it prints a menu at reset and waits for a choice (format `openeit`).
    pub menu: bool,
    /// Number of random bytes that it sends first after a reset.
    pub boot_noise: usize,
    /// Seed of the boot noise.
    pub seed: u64,
}

impl BoardSettings {
    /// A typical board of a format.
    #[must_use]
    pub fn new(kind: WireFormat) -> Self {
        Self {
            kind,
            complex: false,
            layout: (kind == WireFormat::Square).then_some(Layout::Square),
            rotated: false,
            flipped: false,
            counts: false,
            by_drive: false,
            menu: kind == WireFormat::OpenEit,
            boot_noise: 20,
            seed: 1,
        }
    }
}

/// The reason why a board cannot measure a pad.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BoardError {
    /// The pad lacks a reading of the board's layout.
    #[error(
        "the pad {pad} is not measured with the readings of this board: choose another --layout, or a pad with its protocol"
    )]
    OtherProtocol {
        /// The pad.
        pad: String,
    },
    /// The instrument measures only neighbours of 16 or 32 electrodes.
    #[error(
        "{name} measures neighbours of 16 or 32 electrodes, which the pad {pad} is not made for"
    )]
    Instrument {
        /// The format.
        name: &'static str,
        /// The pad.
        pad: String,
    },
}

/// A board that measures a pad.
pub struct Board {
    firmware: Firmware,
    /// For each value of a frame the pad's channel and the sign; none for driven pairs, which are not measured.
    places: Vec<Option<(usize, f32)>>,
}

impl Board {
    /// A board that is wired to a pad.
    ///
    /// # Errors
    /// The board cannot measure the pad.
    pub fn new(pad: &Pad, settings: &BoardSettings) -> Result<Self, BoardError> {
        let protocol = &pad.protocol;
        let electrodes = protocol.electrodes;
        let is_instrument = settings.kind == WireFormat::Sciospec;
        let neighbours = Protocol::pairs_with_step(electrodes, 1);
        let reads_neighbours = || {
            protocol
                .channels
                .iter()
                .all(|c| neighbours.contains(&c.measure))
        };
        if is_instrument && !(matches!(electrodes, 16 | 32) && reads_neighbours()) {
            return Err(BoardError::Instrument {
                name: settings.kind.name(),
                pad: pad.name.clone(),
            });
        }
        let sign = if settings.flipped { -1.0 } else { 1.0 };
        let places = match settings.layout {
            Some(layout) if !is_instrument => listed_places(pad, layout, settings.rotated, sign)?,
            _ => (0..pad.channels())
                .map(|channel| Some((channel, sign)))
                .collect(),
        };
        Ok(Self {
            firmware: Firmware::new(settings, Wiring::from_pad(pad), protocol.clone()),
            places,
        })
    }

    /// The bytes after a reset, which opening the port causes.
    pub fn reset(&mut self) -> Vec<u8> {
        self.firmware.reset()
    }

    /// The answer to bytes from the host.
    pub fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.firmware.receive(bytes)
    }

    /// Whether it would send a frame now.
    #[must_use]
    pub fn is_sending(&self) -> bool {
        self.firmware.is_sending()
    }

    /// The bytes of a frame. `volts` are the pad's voltages, V/A; `time_us` is the time of the board's clock.
    pub fn frame(&mut self, time_us: u64, volts: &[f32]) -> Vec<u8> {
        let pieces = self.frame_pieces(time_us, time_us, volts);
        pieces.into_iter().flat_map(|piece| piece.bytes).collect()
    }

    /// The bytes of a frame that is read drive after drive from one time of the board's clock to another, in the pieces in which
    /// they are sent.
    pub fn frame_pieces(&mut self, from_us: u64, to_us: u64, volts: &[f32]) -> Vec<FramePiece> {
        let values: Vec<f32> = self
            .places
            .iter()
            .map(|place| place.map_or(0.0, |(channel, sign)| sign * volts[channel]))
            .collect();
        self.firmware.frame(from_us, to_us, &values)
    }
}

/// Bytes of a frame that are sent together, or while they are made.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePiece {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// When the first and the last of them are ready, as shares of the time in which the frame is read.
    pub ready: [f64; 2],
}

/// The pad's channels in the order of a layout; a missing reading is replaced by its reciprocal twin.
fn listed_places(
    pad: &Pad,
    layout: Layout,
    rotated: bool,
    sign: f32,
) -> Result<Vec<Option<(usize, f32)>>, BoardError> {
    let mut is_missing = false;
    let places = layout
        .stream_channels(pad.protocol.electrodes, rotated)
        .iter()
        .map(|wanted| {
            let find = |drive, measure| {
                let is_it = |c: &crate::pad::Channel| c.drive == drive && c.measure == measure;
                pad.protocol.channels.iter().position(is_it)
            };
            let place =
                find(wanted.drive, wanted.measure).or_else(|| find(wanted.measure, wanted.drive));
            is_missing |= place.is_none() && !wanted.drive.shares_electrode(wanted.measure);
            place.map(|channel| (channel, sign))
        })
        .collect();
    if is_missing {
        return Err(BoardError::OtherProtocol {
            pad: pad.name.clone(),
        });
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::shipped_pad;
    use crate::source::wire::{Decoded, Dialect, openeit, request, sciospec};

    fn pad(name: &str) -> Pad {
        Pad::from_toml(name, shipped_pad(name).expect("shipped").toml).expect("sound")
    }

    fn frames(dialect: &mut dyn Dialect, bytes: &[u8]) -> usize {
        let mut decoded = Vec::new();
        dialect.feed(0, bytes, &mut decoded);
        let is_frame = |one: &&Decoded| matches!(one, Decoded::Frame(_));
        decoded.iter().filter(is_frame).count()
    }

    #[test]
    fn a_menu_waits_for_its_choice_at_each_reset() {
        let mut board = Board::new(
            &pad("openeit-lattice"),
            &BoardSettings::new(WireFormat::OpenEit),
        )
        .expect("wired");
        for _ in 0..2 {
            let boot = board.reset();
            assert!(String::from_utf8_lossy(&boot).contains("Electrical Impedance Tomography"));
            assert!(!board.is_sending());
            board.receive(b"x\n");
            assert!(!board.is_sending());
            board.receive(openeit::CHOICE);
            assert!(board.is_sending());
        }
        let line = board.frame(0, &[1.0; 192]);
        assert_eq!(frames(&mut openeit::OpenEit::default(), &line), 1);
    }

    #[test]
    fn a_request_is_answered_once() {
        let mut board = Board::new(
            &pad("edinburgh-lattice"),
            &BoardSettings::new(WireFormat::Request),
        )
        .expect("wired");
        board.reset();
        assert!(!board.is_sending());
        board.receive(request::REQUEST);
        assert!(board.is_sending());
        let reply = board.frame(0, &[1.0; 208]);
        assert!(!board.is_sending());
        assert_eq!(frames(&mut request::Request::default(), &reply), 1);
    }

    #[test]
    fn an_instrument_acknowledges_its_set_up_and_starts_on_command() {
        let pad = pad("round-tank");
        let mut board = Board::new(&pad, &BoardSettings::new(WireFormat::Sciospec)).expect("wired");
        let mut host = sciospec::Sciospec::new(&Wiring::from_pad(&pad));
        board.reset();
        let mut commands = 0;
        while let Some(command) = host.poll_command(0) {
            assert!(!board.is_sending());
            let answer = board.receive(&command);
            assert_eq!(answer, [0x18, 1, 0x83, 0x18], "{command:02x?}");
            host.feed(0, &answer, &mut Vec::new());
            commands += 1;
        }
        assert_eq!(commands, 27);
        assert!(board.is_sending());
        let volts: Vec<f32> = (0..208).map(|i| (i % 13) as f32).collect();
        let bytes = [board.frame(0, &volts), board.frame(10_000, &volts)].concat();
        assert_eq!(frames(&mut host, &bytes), 2);
        board.receive(sciospec::STOP);
        assert!(!board.is_sending());
    }

    #[test]
    fn a_layout_that_the_pad_lacks_is_refused() {
        let mut settings = BoardSettings::new(WireFormat::Gelpad);
        settings.layout = Some(Layout::Opposite);
        let error = Board::new(&pad("edinburgh-lattice"), &settings).err();
        assert!(matches!(error, Some(BoardError::OtherProtocol { .. })));
    }
}
