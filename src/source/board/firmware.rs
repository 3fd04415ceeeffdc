//! The firmware of a simulated board: boot, menu, answers to the host, frames.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::{BoardSettings, FramePiece};
use crate::eit::order::Layout;
use crate::pad::{Channel, Pair, Protocol};
use crate::source::wire::{WireFormat, Wiring, gelpad, lines, openeit, request, sciospec, square};

/// Scales from V/A to a board's unit, so that its format keeps enough digits: text with four or five
/// decimals, potentials of an instrument that drives a milliampere, counts of a 24-bit converter.
const TEXT_SCALE: f32 = 100.0;
const INSTRUMENT_SCALE: f32 = 1e-3;
const COUNTS_SCALE: f32 = 8192.0;
/// The menu of the Spectra.
const MENU: &str = "OpenEIT\r\nA) Time Series\r\nB) Bioimpedance Spectroscopy\r\nC) Electrical Impedance Tomography\r\nchoose and press return:\r\n";
/// Bytes from the host that are kept until they complete a command.
const RECEIVE_BUFFER: usize = 512;
/// First bytes of an instrument's commands.
const COMMANDS: std::ops::RangeInclusive<u8> = 0xa1..=0xd3;
/// A board that names its readings does so before each frame whose number is a multiple of this.
const NAMED_FRAMES: u32 = 100;
/// Number of electrodes of an instrument's channel group.
const GROUP: usize = 16;

/// The processor of a board.
pub(super) struct Firmware {
    settings: BoardSettings,
    wiring: Wiring,
    protocol: Protocol,
    random: ChaCha8Rng,
    /// Whether frames are sent without a request.
    is_running: bool,
    /// Number of unanswered requests.
    requests: u32,
    sequence: u32,
    received: Vec<u8>,
}

impl Firmware {
    pub(super) fn new(settings: &BoardSettings, wiring: Wiring, protocol: Protocol) -> Self {
        Self {
            settings: *settings,
            wiring,
            protocol,
            random: ChaCha8Rng::seed_from_u64(settings.seed),
            is_running: false,
            requests: 0,
            sequence: 0,
            received: Vec::new(),
        }
    }

    pub(super) fn reset(&mut self) -> Vec<u8> {
        self.received.clear();
        self.requests = 0;
        self.sequence = 0;
        let mut boot = vec![0; self.settings.boot_noise];
        self.random.fill_bytes(&mut boot);
        match self.settings.kind {
            WireFormat::OpenEit => {
                self.is_running = !self.settings.menu;
                boot.extend_from_slice(b"\r\n");
                boot.extend_from_slice(if self.is_running {
                    b"OpenEIT\r\n"
                } else {
                    MENU.as_bytes()
                });
            }
            WireFormat::Request | WireFormat::Sciospec => self.is_running = false,
            WireFormat::Square | WireFormat::Lines => {
                self.is_running = true;
                boot.extend_from_slice(b"\r\nready\r\n");
            }
            WireFormat::Gelpad => {
                self.is_running = true;
                // A zero first: it ends whatever was sent before.
                boot.push(0);
            }
        }
        boot
    }

    pub(super) fn is_sending(&self) -> bool {
        self.is_running || self.requests > 0
    }

    pub(super) fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        let room = RECEIVE_BUFFER - self.received.len();
        self.received
            .extend_from_slice(&bytes[..bytes.len().min(room)]);
        match self.settings.kind {
            WireFormat::OpenEit => self.receive_choice(),
            WireFormat::Request => {
                let asked = self
                    .received
                    .drain(..)
                    .filter(|byte| [*byte] == *request::REQUEST);
                self.requests = (self.requests + asked.count() as u32).min(2);
                Vec::new()
            }
            WireFormat::Sciospec => self.receive_commands(),
            _ => {
                self.received.clear();
                Vec::new()
            }
        }
    }

    /// Handles a letter and return.
    fn receive_choice(&mut self) -> Vec<u8> {
        let mut answer = Vec::new();
        while let Some(end) = self.received.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.received.drain(..=end).collect();
            if line == openeit::CHOICE {
                if !self.is_running {
                    answer.extend_from_slice(b"mode 3: imaging\r\n");
                }
                self.is_running = true;
            } else {
                answer.extend_from_slice(b"no mode chosen\r\n");
            }
        }
        if self.received.len() == RECEIVE_BUFFER {
            self.received.clear();
        }
        answer
    }

    /// Commands `CT LEN data CT`: each is acknowledged, a wrong one is refused, and bytes that start no
    /// command are skipped.
    fn receive_commands(&mut self) -> Vec<u8> {
        let mut answers = Vec::new();
        while let [tag, length, ..] = self.received[..] {
            let whole = usize::from(length) + 3;
            if !COMMANDS.contains(&tag) {
                self.received.remove(0);
                continue;
            }
            if self.received.len() < whole {
                break;
            }
            let command: Vec<u8> = self.received.drain(..whole).collect();
            let answer = if command[whole - 1] != tag {
                self.received.clear();
                0x82
            } else {
                match command[..] {
                    [sciospec::MEASURE, 1, on @ (0 | 1), _] => {
                        self.is_running = on == 1;
                        sciospec::DONE
                    }
                    [sciospec::SET_UP | sciospec::OUTPUT, ..] => sciospec::DONE,
                    _ => 0x81,
                }
            };
            answers.extend_from_slice(&[sciospec::ACK, 1, answer, sciospec::ACK]);
        }
        answers
    }

    /// The pieces of a frame that is read from one time to another. Text is printed while the frame is read.
    pub(super) fn frame(&mut self, from_us: u64, to_us: u64, values: &[f32]) -> Vec<FramePiece> {
        self.requests = self.requests.saturating_sub(1);
        let sequence = self.sequence;
        self.sequence = self.sequence.wrapping_add(1);
        let scaled =
            |scale: f32| -> Vec<f32> { values.iter().map(|value| scale * value).collect() };
        let printed = |bytes: Vec<u8>| {
            vec![FramePiece {
                bytes,
                ready: [0.0, 1.0],
            }]
        };
        match self.settings.kind {
            WireFormat::OpenEit => {
                let magnitudes: Vec<f32> =
                    scaled(TEXT_SCALE).iter().map(|value| value.abs()).collect();
                printed(openeit::encode(&magnitudes).into_bytes())
            }
            WireFormat::Square => printed(square::encode(&scaled(TEXT_SCALE)).into_bytes()),
            WireFormat::Request => printed(request::encode(&scaled(TEXT_SCALE)).into_bytes()),
            WireFormat::Lines => printed(lines::encode(values, self.settings.complex).into_bytes()),
            WireFormat::Gelpad if self.settings.counts => {
                let counts = scaled(COUNTS_SCALE);
                self.packets(gelpad::Values::I32, sequence, [from_us, to_us], &counts)
            }
            WireFormat::Gelpad => {
                self.packets(gelpad::Values::F32, sequence, [from_us, to_us], values)
            }
            WireFormat::Sciospec => self.rows([from_us, to_us], &scaled(INSTRUMENT_SCALE)),
        }
    }

    /// One packet, or one for each drive.
    fn packets(
        &self,
        kind: gelpad::Values,
        sequence: u32,
        [from_us, to_us]: [u64; 2],
        values: &[f32],
    ) -> Vec<FramePiece> {
        let mut named = if self.names_readings() && sequence.is_multiple_of(NAMED_FRAMES) {
            gelpad::encode_listing(&self.protocol.channels)
        } else {
            Vec::new()
        };
        if !self.settings.by_drive {
            named.extend(gelpad::encode(kind, sequence, to_us as u32, values));
            return vec![FramePiece {
                bytes: named,
                ready: [1.0; 2],
            }];
        }
        let bounds = self.part_bounds(values.len());
        bounds
            .windows(2)
            .map(|part| {
                let share = part[1] as f64 / values.len() as f64;
                let time_us = from_us + (share * (to_us - from_us) as f64) as u64;
                let mut bytes = std::mem::take(&mut named);
                bytes.extend(gelpad::encode_part(
                    kind,
                    sequence,
                    time_us as u32,
                    values,
                    part[0]..part[1],
                ));
                FramePiece {
                    bytes,
                    ready: [share; 2],
                }
            })
            .collect()
    }

    /// Whether its order is the pad's own, which no layout has.
    fn names_readings(&self) -> bool {
        let protocol = &self.protocol;
        self.settings.layout.is_none()
            && Layout::of_channels(&protocol.channels, protocol.electrodes).is_none()
    }

    /// Where the readings of each drive begin, and the end of the last. Layouts read each drive equally often.
    fn part_bounds(&self, values: usize) -> Vec<usize> {
        if self.settings.layout.is_none() {
            return self.protocol.drive_bounds();
        }
        let drives = self.wiring.drives.len();
        (0..=drives).map(|drive| values * drive / drives).collect()
    }

    /// Potentials whose differences are the values; where no value links a potential to its neighbour, it starts at zero.
    fn rows(&self, [from_us, to_us]: [u64; 2], values: &[f32]) -> Vec<FramePiece> {
        let electrodes = self.wiring.electrodes;
        let mut pieces = Vec::new();
        let count = self.wiring.drives.len();
        for (index, drive) in self.wiring.drives.iter().enumerate() {
            let share = (index + 1) as f64 / count as f64;
            let ms = ((from_us as f64 + share * (to_us - from_us) as f64) / 1000.0) as u32;
            let value = |measure: Pair| {
                let wanted = Channel {
                    drive: *drive,
                    measure,
                };
                let place = self
                    .protocol
                    .channels
                    .iter()
                    .position(|channel| *channel == wanted);
                place.map(|place| values[place])
            };
            // Once around, starting after the drive, so that a chain of neighbours is not cut at electrode 0.
            let mut potentials = vec![0.0_f32; electrodes];
            let start = (drive.1 + 1) % electrodes;
            for step in 0..electrodes - 1 {
                let measure = Pair((start + step) % electrodes, (start + step + 1) % electrodes);
                if let Some(difference) = value(measure) {
                    potentials[measure.1] = potentials[measure.0] + difference;
                }
            }
            let rows = potentials.chunks(GROUP).enumerate();
            pieces.push(FramePiece {
                bytes: rows
                    .flat_map(|(group, row)| sciospec::encode_row(group, *drive, ms, row))
                    .collect(),
                ready: [share; 2],
            });
        }
        pieces
    }
}
