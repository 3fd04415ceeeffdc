//! A simulated board: what its firmware does with a pad's voltages and with what the host sends, in every wire format.
//!
//! It lives in the library because tests, demonstrations and whoever writes firmware share it. The board itself does no IO
//! and reads no clock; [`serve()`] gives it a pseudo-terminal and the time.

mod faults;
mod firmware;
#[cfg(unix)]
mod pty;
#[cfg(unix)]
mod serve;
mod signal;

pub use faults::{Cable, Every, Faults};
#[cfg(unix)]
pub use pty::Pty;
#[cfg(unix)]
pub use serve::{Plan, Served, serve};
pub use signal::{LostElectrode, Signal};

use crate::eit::order::Layout;
use crate::pad::{Pad, Protocol};
use crate::source::wire::{FormatKind, Wiring};
use firmware::Firmware;

/// What a simulated board is.
#[derive(Clone, Copy, Debug)]
pub struct BoardSettings {
    /// What it speaks.
    pub kind: FormatKind,
    /// Whether values are pairs of real and imaginary part (of `lines`).
    pub complex: bool,
    /// What it lists; none: the pad's own readings in the pad's order.
    pub layout: Option<Layout>,
    /// Whether each drive's measurements begin behind the drive.
    pub rotated: bool,
    /// Whether the meter's leads are the other way round.
    pub flipped: bool,
    /// Whether values are whole counts of a converter (of `gelpad`).
    pub counts: bool,
    /// Whether it prints a menu at reset and waits for a choice (of `openeit`).
    pub menu: bool,
    /// Random bytes that come before anything else after a reset.
    pub boot_noise: usize,
    /// Seed of the boot noise.
    pub seed: u64,
}

impl BoardSettings {
    /// A board of a format as it is sold.
    #[must_use]
    pub fn new(kind: FormatKind) -> Self {
        Self {
            kind,
            complex: false,
            layout: (kind == FormatKind::Square).then_some(Layout::Square),
            rotated: false,
            flipped: false,
            counts: false,
            menu: kind == FormatKind::OpenEit,
            boot_noise: 20,
            seed: 1,
        }
    }
}

/// Why a board cannot read a pad.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BoardError {
    /// The pad lacks a reading that the board lists.
    #[error(
        "the pad {pad} is not measured with what this board lists: choose another --layout, or a pad of its protocol"
    )]
    OtherProtocol {
        /// The pad.
        pad: String,
    },
    /// The instrument reads neighbours of sixteen or thirty-two electrodes.
    #[error(
        "{name} reads differences of neighbours of 16 or 32 electrodes: the pad {pad} is another"
    )]
    Instrument {
        /// The format.
        name: &'static str,
        /// The pad.
        pad: String,
    },
}

/// A board that reads a pad.
pub struct Board {
    firmware: Firmware,
    /// For each value that is sent, the pad's channel and the sign; none for driven pairs, which are not measured.
    places: Vec<Option<(usize, f32)>>,
}

impl Board {
    /// A board wired to a pad.
    ///
    /// # Errors
    /// A pad that it cannot read.
    pub fn new(pad: &Pad, settings: &BoardSettings) -> Result<Self, BoardError> {
        let protocol = &pad.protocol;
        let electrodes = protocol.electrodes;
        let is_instrument = settings.kind == FormatKind::Sciospec;
        let neighbours = Protocol::stepped(electrodes, 1);
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
            Some(layout) if !is_instrument => listed(pad, layout, settings.rotated, sign)?,
            _ => (0..pad.channels())
                .map(|channel| Some((channel, sign)))
                .collect(),
        };
        Ok(Self {
            firmware: Firmware::new(settings, Wiring::of_pad(pad), protocol.clone()),
            places,
        })
    }

    /// What comes when the board is powered or reset: opening the port does that.
    pub fn reset(&mut self) -> Vec<u8> {
        self.firmware.reset()
    }

    /// What it answers to bytes of the host's.
    pub fn hear(&mut self, bytes: &[u8]) -> Vec<u8> {
        self.firmware.hear(bytes)
    }

    /// Whether it would send a frame now.
    #[must_use]
    pub fn is_sending(&self) -> bool {
        self.firmware.is_sending()
    }

    /// The bytes of a frame: the pad's voltages, V/A, at a time of the board's clock.
    pub fn frame(&mut self, time_us: u64, volts: &[f32]) -> Vec<u8> {
        let values: Vec<f32> = self
            .places
            .iter()
            .map(|place| place.map_or(0.0, |(channel, sign)| sign * volts[channel]))
            .collect();
        self.firmware.frame(time_us, &values)
    }
}

/// Where a pad's channels stand in a layout; a reading that the pad has only as its reciprocal twin is that one.
fn listed(
    pad: &Pad,
    layout: Layout,
    rotated: bool,
    sign: f32,
) -> Result<Vec<Option<(usize, f32)>>, BoardError> {
    let mut is_missing = false;
    let places = layout
        .stream(pad.protocol.electrodes, rotated)
        .iter()
        .map(|wanted| {
            let find = |drive, measure| {
                let is_it = |c: &crate::pad::Channel| c.drive == drive && c.measure == measure;
                pad.protocol.channels.iter().position(is_it)
            };
            let place =
                find(wanted.drive, wanted.measure).or_else(|| find(wanted.measure, wanted.drive));
            is_missing |= place.is_none() && !wanted.drive.meets(wanted.measure);
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
            &BoardSettings::new(FormatKind::OpenEit),
        )
        .expect("wired");
        for _ in 0..2 {
            let boot = board.reset();
            assert!(String::from_utf8_lossy(&boot).contains("Electrical Impedance Tomography"));
            assert!(!board.is_sending());
            board.hear(b"x\n");
            assert!(!board.is_sending());
            board.hear(openeit::CHOICE);
            assert!(board.is_sending());
        }
        let line = board.frame(0, &[1.0; 192]);
        assert_eq!(frames(&mut openeit::OpenEit::default(), &line), 1);
    }

    #[test]
    fn a_request_is_answered_once() {
        let mut board = Board::new(
            &pad("edinburgh-lattice"),
            &BoardSettings::new(FormatKind::Request),
        )
        .expect("wired");
        board.reset();
        assert!(!board.is_sending());
        board.hear(request::REQUEST);
        assert!(board.is_sending());
        let reply = board.frame(0, &[1.0; 208]);
        assert!(!board.is_sending());
        assert_eq!(frames(&mut request::Request::default(), &reply), 1);
    }

    #[test]
    fn an_instrument_acknowledges_its_set_up_and_starts_when_told() {
        let pad = pad("round-tank");
        let mut board = Board::new(&pad, &BoardSettings::new(FormatKind::Sciospec)).expect("wired");
        let mut host = sciospec::Sciospec::new(&Wiring::of_pad(&pad));
        board.reset();
        let mut commands = 0;
        while let Some(command) = host.say(0) {
            assert!(!board.is_sending());
            let answer = board.hear(&command);
            assert_eq!(answer, [0x18, 1, 0x83, 0x18], "{command:02x?}");
            host.feed(0, &answer, &mut Vec::new());
            commands += 1;
        }
        assert_eq!(commands, 27);
        assert!(board.is_sending());
        let volts: Vec<f32> = (0..208).map(|i| (i % 13) as f32).collect();
        let bytes = [board.frame(0, &volts), board.frame(10_000, &volts)].concat();
        assert_eq!(frames(&mut host, &bytes), 2);
        board.hear(sciospec::STOP);
        assert!(!board.is_sending());
    }

    #[test]
    fn what_the_pad_lacks_cannot_be_listed() {
        let mut settings = BoardSettings::new(FormatKind::Gelpad);
        settings.layout = Some(Layout::Opposite);
        let error = Board::new(&pad("edinburgh-lattice"), &settings).err();
        assert!(matches!(error, Some(BoardError::OtherProtocol { .. })));
    }
}
