//! Finds out which format a board speaks.
//!
//! All formats decode in parallel. The one with complete frames that is identified most surely wins: a check
//! sum or a closing word needs one frame, a line of numbers three of the same length. If no frame is
//! recognised within [`LISTEN_NS`], the known start commands are sent one after the other, which is announced
//! to the player first. If a board had frames and then has none for as long, detection starts again.

use super::{Decoded, Dialect, WireFormat, Wiring, openeit, request, sciospec};
use crate::types::{NANOS_PER_MS, Nanos};

/// How long a board is listened to before anything is sent.
pub const LISTEN_NS: Nanos = 3000 * NANOS_PER_MS;
/// How long an answer to a start command is awaited.
const ANSWER_NS: Nanos = 1500 * NANOS_PER_MS;
/// Known start commands, in the order in which they are tried: commands that other boards ignore come first.
const COMMANDS: [(WireFormat, &[u8], &str); 3] = [
    (WireFormat::OpenEit, openeit::CHOICE, "the menu choice `c`"),
    (WireFormat::Request, request::REQUEST, "the request `D`"),
    (WireFormat::Sciospec, sciospec::START, "Sciospec's start"),
];

/// How often all of them are tried: what a board printed at reset may garble the first answer.
const ROUNDS: usize = 2;

/// Speaks the format that the board speaks.
pub struct Auto {
    wiring: Wiring,
    candidates: Vec<Candidate>,
    chosen_dialect: Option<Box<dyn Dialect>>,
    /// When detection started.
    since_ns: Nanos,
    /// Arrival of the last frame.
    frame_ns: Nanos,
    received_bytes: u64,
    received_since_frame: bool,
    /// Number of commands sent.
    tried: usize,
    announced: bool,
    given_up: bool,
    hands_up: bool,
    notes: Vec<String>,
}

/// A format that decodes along.
struct Candidate {
    kind: WireFormat,
    dialect: Box<dyn Dialect>,
    /// The last frames, which all have `length` values.
    run: Vec<Decoded>,
    length: usize,
}

impl Candidate {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8]) {
        let mut decoded = Vec::new();
        self.dialect.feed(now_ns, bytes, &mut decoded);
        for one in decoded {
            if let Decoded::Frame(frame) = &one {
                if frame.values.len() != self.length {
                    self.run.clear();
                    self.length = frame.values.len();
                }
                self.run.push(one);
            }
        }
    }

    fn is_sure(&self) -> bool {
        self.run.len()
            >= match self.kind {
                WireFormat::Gelpad | WireFormat::Request | WireFormat::Sciospec => 1,
                WireFormat::OpenEit => 2,
                WireFormat::Square | WireFormat::Lines => 3,
            }
    }
}

impl Auto {
    /// For a board on a pad with this wiring.
    #[must_use]
    pub fn new(wiring: Wiring) -> Self {
        Self {
            candidates: candidates(&wiring),
            wiring,
            chosen_dialect: None,
            since_ns: 0,
            frame_ns: 0,
            received_bytes: 0,
            received_since_frame: false,
            tried: 0,
            announced: false,
            given_up: false,
            hands_up: false,
            notes: Vec::new(),
        }
    }

    fn restart(&mut self, now_ns: Nanos) {
        let wiring = self.wiring.clone();
        let notes = std::mem::take(&mut self.notes);
        let hands_up = self.hands_up;
        *self = Self::new(wiring);
        if hands_up {
            self.hand_up_readings();
        }
        self.notes = notes;
        self.since_ns = now_ns;
        self.frame_ns = now_ns;
    }

    fn choose_format(&mut self, now_ns: Nanos, decoded: &mut Vec<Decoded>) {
        let Some(index) = self.candidates.iter().position(Candidate::is_sure) else {
            return;
        };
        let candidate = self.candidates.swap_remove(index);
        self.candidates.clear();
        let (kind, count) = (candidate.kind, candidate.length);
        decoded.push(Decoded::Note(format!(
            "the board speaks {} (--format {}), {count} values a frame",
            kind.description(),
            kind.name()
        )));
        decoded.extend(candidate.run);
        self.chosen_dialect = Some(candidate.dialect);
        self.frame_ns = now_ns;
    }
}

fn candidates(wiring: &Wiring) -> Vec<Candidate> {
    WireFormat::ALL
        .into_iter()
        .map(|kind| Candidate {
            kind,
            dialect: match kind {
                // An instrument that already sends is not set up again.
                WireFormat::Sciospec => Box::new(sciospec::Sciospec::running(wiring)),
                _ => kind.dialect(wiring, false),
            },
            run: Vec::new(),
            length: 0,
        })
        .collect()
}

impl Dialect for Auto {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        self.received_bytes += bytes.len() as u64;
        self.received_since_frame |= !bytes.is_empty();
        match &mut self.chosen_dialect {
            Some(chosen_dialect) => {
                let before = decoded.len();
                chosen_dialect.feed(now_ns, bytes, decoded);
                let has_frame = |one: &Decoded| matches!(one, Decoded::Frame(_));
                if decoded[before..].iter().any(has_frame) {
                    self.frame_ns = now_ns;
                    self.received_since_frame = false;
                }
            }
            None => {
                for candidate in &mut self.candidates {
                    candidate.feed(now_ns, bytes);
                }
                self.choose_format(now_ns, decoded);
            }
        }
        decoded.extend(self.notes.drain(..).map(Decoded::Note));
    }

    fn hand_up_readings(&mut self) {
        self.hands_up = true;
        for candidate in &mut self.candidates {
            candidate.dialect.hand_up_readings();
        }
        if let Some(chosen_dialect) = &mut self.chosen_dialect {
            chosen_dialect.hand_up_readings();
        }
    }

    fn poll_command(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        if let Some(chosen_dialect) = &mut self.chosen_dialect {
            if self.received_since_frame && now_ns.saturating_sub(self.frame_ns) > LISTEN_NS {
                self.notes
                    .push("no frames any more: detecting the format again".to_owned());
                self.restart(now_ns);
                return None;
            }
            return chosen_dialect.poll_command(now_ns);
        }
        let listened_ns = now_ns.saturating_sub(self.since_ns);
        if listened_ns < LISTEN_NS {
            return None;
        }
        let received = self.received_bytes;
        if !self.announced {
            self.announced = true;
            let names: Vec<&str> = COMMANDS.iter().map(|(_, _, name)| *name).collect();
            self.notes.push(format!(
                "{received} bytes in {} s, but no frame: sending {}, one after the other",
                LISTEN_NS / 1_000_000_000,
                names.join(", ")
            ));
            return None;
        }
        if listened_ns < LISTEN_NS + self.tried as Nanos * ANSWER_NS {
            return None;
        }
        let is_over = self.tried == ROUNDS * COMMANDS.len();
        let (kind, command, _) = COMMANDS[self.tried % COMMANDS.len()];
        if is_over {
            if !self.given_up {
                self.given_up = true;
                self.notes.push(format!(
                    "no frame in any known format ({received} bytes received): still listening; `gelpad listen` shows the bytes, --format selects a format"
                ));
            }
            return None;
        }
        self.tried += 1;
        tracing::debug!("trying {}", kind.name());
        Some(command.to_vec())
    }

    fn reopened(&mut self) {
        match &mut self.chosen_dialect {
            Some(chosen_dialect) => chosen_dialect.reopened(),
            None => self.restart(0),
        }
        self.frame_ns = 0;
        self.received_since_frame = false;
    }

    fn stop_command(&self) -> &'static [u8] {
        match &self.chosen_dialect {
            Some(chosen_dialect) => chosen_dialect.stop_command(),
            None => &[],
        }
    }

    fn held_bytes(&self) -> usize {
        let run = |candidate: &Candidate| -> usize {
            candidate.run.len() * candidate.length * 4 + candidate.dialect.held_bytes()
        };
        self.candidates.iter().map(run).sum::<usize>()
            + self
                .chosen_dialect
                .as_ref()
                .map_or(0, |chosen_dialect| chosen_dialect.held_bytes())
    }

    fn kind(&self) -> Option<WireFormat> {
        self.chosen_dialect.as_ref()?.kind()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests_support::frames;
    use super::super::{gelpad, lines, square};
    use super::*;

    fn auto() -> Auto {
        Auto::new(Wiring::adjacent(16))
    }

    fn notes(decoded: &[Decoded]) -> Vec<String> {
        decoded
            .iter()
            .filter_map(|one| match one {
                Decoded::Note(text) => Some(text.clone()),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn each_format_is_recognised_and_no_frame_is_lost() {
        let values: Vec<f32> = (0..256).map(|i| i as f32 * 0.25).collect();
        let part = &values[..208];
        let rows: Vec<u8> = (0..16)
            .flat_map(|drive| {
                sciospec::encode_row(
                    0,
                    crate::pad::Pair(drive, (drive + 1) % 16),
                    1,
                    &values[..16],
                )
            })
            .collect();
        let cases: [(WireFormat, Vec<u8>, usize); 6] = [
            (
                WireFormat::Gelpad,
                gelpad::encode(gelpad::Values::F32, 1, 1, part),
                1,
            ),
            (WireFormat::Sciospec, rows, 2),
            (WireFormat::OpenEit, openeit::encode(part).into_bytes(), 2),
            (WireFormat::Request, request::encode(part).into_bytes(), 1),
            (WireFormat::Square, square::encode(&values).into_bytes(), 3),
            (
                WireFormat::Lines,
                lines::encode(part, false).into_bytes(),
                3,
            ),
        ];
        for (kind, frame, needed) in cases {
            let mut board = auto();
            let mut decoded = Vec::new();
            for _ in 0..needed {
                assert_eq!(board.kind(), None);
                board.feed(0, &frame, &mut decoded);
            }
            assert_eq!(board.kind(), Some(kind));
            board.feed(0, &frame, &mut decoded);
            assert_eq!(frames(&decoded).len(), needed + 1, "{kind:?}");
        }
    }

    #[test]
    fn start_commands_are_announced_and_sent_to_a_silent_board() {
        let mut board = auto();
        let mut decoded = Vec::new();
        assert_eq!(board.poll_command(LISTEN_NS - 1), None);
        assert_eq!(board.poll_command(LISTEN_NS), None, "it is announced first");
        board.feed(LISTEN_NS, b"", &mut decoded);
        assert_eq!(
            notes(&decoded),
            [
                "0 bytes in 3 s, but no frame: sending the menu choice `c`, the request `D`, Sciospec's start, one after the other"
            ]
        );
        let sent: Vec<Vec<u8>> = (0..200)
            .filter_map(|step| board.poll_command(LISTEN_NS + step * ANSWER_NS / 10))
            .collect();
        assert_eq!(sent[..3], sent[3..], "twice");
        assert_eq!(
            sent[..3],
            [openeit::CHOICE, request::REQUEST, sciospec::START]
        );
        board.feed(0, b"", &mut decoded);
        assert!(notes(&decoded)[1].starts_with("no frame in any known format"));
    }

    #[test]
    fn a_change_of_format_is_detected() {
        let mut board = auto();
        let mut decoded = Vec::new();
        let packet = gelpad::encode(gelpad::Values::F32, 1, 1, &[1.0; 208]);
        board.feed(0, &packet, &mut decoded);
        let line = openeit::encode(&[2.0; 208]);
        board.feed(LISTEN_NS / 2, line.as_bytes(), &mut decoded);
        board.feed(LISTEN_NS, line.as_bytes(), &mut decoded);
        assert_eq!(board.poll_command(LISTEN_NS + 1), None);
        assert_eq!(board.kind(), None);
        for _ in 0..2 {
            board.feed(LISTEN_NS + 2, line.as_bytes(), &mut decoded);
        }
        assert_eq!(board.kind(), Some(WireFormat::OpenEit));
        assert_eq!(frames(&decoded).len(), 3);
    }
}
