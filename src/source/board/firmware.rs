//! What a board's processor does: boot, menu, answers to the host, frames.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::BoardSettings;
use crate::pad::{Channel, Pair, Protocol};
use crate::source::wire::{FormatKind, Wiring, gelpad, lines, openeit, request, sciospec, square};

/// What a board's converter makes of a volt per ampere, so that its format keeps enough digits: text with four or five
/// decimals, potentials of an instrument that drives a milliampere, counts of a converter of 24 bits.
const TEXT_SCALE: f32 = 100.0;
const INSTRUMENT_SCALE: f32 = 1e-3;
const COUNTS_SCALE: f32 = 8192.0;
/// What the Spectra prints at reset.
const MENU: &str = "OpenEIT\r\nA) Time Series\r\nB) Bioimpedance Spectroscopy\r\nC) Electrical Impedance Tomography\r\nchoose and press return:\r\n";
/// Bytes of the host's that are kept until they make a command.
const MOST_HEARD: usize = 512;
/// What an instrument's commands begin with.
const COMMANDS: std::ops::RangeInclusive<u8> = 0xa1..=0xd3;
/// Electrodes of an instrument's channel group.
const GROUP: usize = 16;

/// The processor of a board.
pub(super) struct Firmware {
    settings: BoardSettings,
    wiring: Wiring,
    protocol: Protocol,
    random: ChaCha8Rng,
    /// Whether frames go out by themselves.
    runs: bool,
    /// Requests that are not answered yet.
    requests: u32,
    sequence: u32,
    heard: Vec<u8>,
}

impl Firmware {
    pub(super) fn new(settings: &BoardSettings, wiring: Wiring, protocol: Protocol) -> Self {
        Self {
            settings: *settings,
            wiring,
            protocol,
            random: ChaCha8Rng::seed_from_u64(settings.seed),
            runs: false,
            requests: 0,
            sequence: 0,
            heard: Vec::new(),
        }
    }

    pub(super) fn reset(&mut self) -> Vec<u8> {
        self.heard.clear();
        self.requests = 0;
        self.sequence = 0;
        let mut boot = vec![0; self.settings.boot_noise];
        self.random.fill_bytes(&mut boot);
        match self.settings.kind {
            FormatKind::OpenEit => {
                self.runs = !self.settings.menu;
                boot.extend_from_slice(b"\r\n");
                boot.extend_from_slice(if self.runs {
                    b"OpenEIT\r\n"
                } else {
                    MENU.as_bytes()
                });
            }
            FormatKind::Request | FormatKind::Sciospec => self.runs = false,
            FormatKind::Square | FormatKind::Lines => {
                self.runs = true;
                boot.extend_from_slice(b"\r\nready\r\n");
            }
            FormatKind::Gelpad => {
                self.runs = true;
                // A zero first: what came before is no packet.
                boot.push(0);
            }
        }
        boot
    }

    pub(super) fn is_sending(&self) -> bool {
        self.runs || self.requests > 0
    }

    pub(super) fn hear(&mut self, bytes: &[u8]) -> Vec<u8> {
        let room = MOST_HEARD - self.heard.len();
        self.heard
            .extend_from_slice(&bytes[..bytes.len().min(room)]);
        match self.settings.kind {
            FormatKind::OpenEit => self.hear_choice(),
            FormatKind::Request => {
                let asked = self
                    .heard
                    .drain(..)
                    .filter(|byte| [*byte] == *request::REQUEST);
                self.requests = (self.requests + asked.count() as u32).min(2);
                Vec::new()
            }
            FormatKind::Sciospec => self.hear_commands(),
            _ => {
                self.heard.clear();
                Vec::new()
            }
        }
    }

    /// A letter and return.
    fn hear_choice(&mut self) -> Vec<u8> {
        let mut answer = Vec::new();
        while let Some(end) = self.heard.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = self.heard.drain(..=end).collect();
            if line == openeit::CHOICE {
                if !self.runs {
                    answer.extend_from_slice(b"mode 3: imaging\r\n");
                }
                self.runs = true;
            } else {
                answer.extend_from_slice(b"no mode chosen\r\n");
            }
        }
        if self.heard.len() == MOST_HEARD {
            self.heard.clear();
        }
        answer
    }

    /// Commands `CT LEN data CT`, each acknowledged; what is none is refused, and bytes that begin none are passed over.
    fn hear_commands(&mut self) -> Vec<u8> {
        let mut answers = Vec::new();
        while let [tag, length, ..] = self.heard[..] {
            let whole = usize::from(length) + 3;
            if !COMMANDS.contains(&tag) {
                self.heard.remove(0);
                continue;
            }
            if self.heard.len() < whole {
                break;
            }
            let command: Vec<u8> = self.heard.drain(..whole).collect();
            let answer = if command[whole - 1] != tag {
                self.heard.clear();
                0x82
            } else {
                match command[..] {
                    [sciospec::MEASURE, 1, on @ (0 | 1), _] => {
                        self.runs = on == 1;
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

    pub(super) fn frame(&mut self, time_us: u64, values: &[f32]) -> Vec<u8> {
        self.requests = self.requests.saturating_sub(1);
        let sequence = self.sequence;
        self.sequence = self.sequence.wrapping_add(1);
        let scaled =
            |scale: f32| -> Vec<f32> { values.iter().map(|value| scale * value).collect() };
        match self.settings.kind {
            FormatKind::OpenEit => {
                let magnitudes: Vec<f32> =
                    scaled(TEXT_SCALE).iter().map(|value| value.abs()).collect();
                openeit::encode(&magnitudes).into_bytes()
            }
            FormatKind::Square => square::encode(&scaled(TEXT_SCALE)).into_bytes(),
            FormatKind::Request => request::encode(&scaled(TEXT_SCALE)).into_bytes(),
            FormatKind::Lines => lines::encode(values, self.settings.complex).into_bytes(),
            FormatKind::Gelpad if self.settings.counts => gelpad::encode(
                gelpad::Values::I32,
                sequence,
                time_us as u32,
                &scaled(COUNTS_SCALE),
            ),
            FormatKind::Gelpad => {
                gelpad::encode(gelpad::Values::F32, sequence, time_us as u32, values)
            }
            FormatKind::Sciospec => self.rows((time_us / 1000) as u32, &scaled(INSTRUMENT_SCALE)),
        }
    }

    /// Potentials whose differences are the values: what no value ties to its neighbour begins at zero.
    fn rows(&self, ms: u32, values: &[f32]) -> Vec<u8> {
        let electrodes = self.wiring.electrodes;
        let mut rows = Vec::new();
        for drive in &self.wiring.drives {
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
            // Round once from behind the drive, so that a chain of neighbours is not cut at electrode 0.
            let mut potentials = vec![0.0_f32; electrodes];
            let start = (drive.1 + 1) % electrodes;
            for step in 0..electrodes - 1 {
                let measure = Pair((start + step) % electrodes, (start + step + 1) % electrodes);
                if let Some(difference) = value(measure) {
                    potentials[measure.1] = potentials[measure.0] + difference;
                }
            }
            for (group, potentials) in potentials.chunks(GROUP).enumerate() {
                rows.extend(sciospec::encode_row(group, *drive, ms, potentials));
            }
        }
        rows
    }
}
