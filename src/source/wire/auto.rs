//! Finding out which format a board speaks.
//!
//! All formats read along. The one that is told most surely and has whole frames wins: a check sum or a closing word
//! needs one frame, a line of numbers three of the same length. A board that says nothing in [`LISTEN_NS`] is sent the
//! known start commands, one after the other, and the player is told so before. Who had frames and then has none for as
//! long is listened to anew.

use super::{Decoded, Dialect, FormatKind, Wiring, openeit, request, sciospec};
use crate::types::{NANOS_PER_MS, Nanos};

/// How long a board is listened to before anything is sent.
pub const LISTEN_NS: Nanos = 3000 * NANOS_PER_MS;
/// How long an answer to a start command is waited for.
const ANSWER_NS: Nanos = 1500 * NANOS_PER_MS;
/// Known start commands, in the order in which they are tried: those that other boards ignore first.
const COMMANDS: [(FormatKind, &[u8], &str); 3] = [
    (FormatKind::OpenEit, openeit::CHOICE, "the menu choice `c`"),
    (FormatKind::Request, request::REQUEST, "the request `D`"),
    (FormatKind::Sciospec, sciospec::START, "Sciospec's start"),
];

/// How often they are all tried: what a board printed at reset may spoil the first answer.
const ROUNDS: usize = 2;

/// Speaks whatever the board speaks.
pub struct Auto {
    wiring: Wiring,
    candidates: Vec<Candidate>,
    spoken: Option<Box<dyn Dialect>>,
    /// When listening began.
    since_ns: Nanos,
    /// When a frame last came.
    frame_ns: Nanos,
    heard_bytes: u64,
    heard_since_frame: bool,
    /// How many of the commands were sent.
    tried: usize,
    announced: bool,
    given_up: bool,
    notes: Vec<String>,
}

/// A format that reads along.
struct Candidate {
    kind: FormatKind,
    dialect: Box<dyn Dialect>,
    /// Frames of the same length, one after the other, that length, and the newest.
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
                FormatKind::Gelpad | FormatKind::Request | FormatKind::Sciospec => 1,
                FormatKind::OpenEit => 2,
                FormatKind::Square | FormatKind::Lines => 3,
            }
    }
}

impl Auto {
    /// For a board on a pad that is wired so.
    #[must_use]
    pub fn new(wiring: Wiring) -> Self {
        Self {
            candidates: candidates(&wiring),
            wiring,
            spoken: None,
            since_ns: 0,
            frame_ns: 0,
            heard_bytes: 0,
            heard_since_frame: false,
            tried: 0,
            announced: false,
            given_up: false,
            notes: Vec::new(),
        }
    }

    fn listen_anew(&mut self, now_ns: Nanos) {
        let wiring = self.wiring.clone();
        let notes = std::mem::take(&mut self.notes);
        *self = Self::new(wiring);
        self.notes = notes;
        self.since_ns = now_ns;
        self.frame_ns = now_ns;
    }

    fn choose(&mut self, now_ns: Nanos, decoded: &mut Vec<Decoded>) {
        let Some(index) = self.candidates.iter().position(Candidate::is_sure) else {
            return;
        };
        let chosen = self.candidates.swap_remove(index);
        self.candidates.clear();
        let (kind, count) = (chosen.kind, chosen.length);
        decoded.push(Decoded::Note(format!(
            "the board speaks {} (--format {}), {count} values a frame",
            kind.about(),
            kind.name()
        )));
        decoded.extend(chosen.run);
        self.spoken = Some(chosen.dialect);
        self.frame_ns = now_ns;
    }
}

fn candidates(wiring: &Wiring) -> Vec<Candidate> {
    FormatKind::ALL
        .into_iter()
        .map(|kind| Candidate {
            kind,
            dialect: match kind {
                // An instrument that sends is left as it is set up.
                FormatKind::Sciospec => Box::new(sciospec::Sciospec::running(wiring)),
                _ => kind.dialect(wiring, false),
            },
            run: Vec::new(),
            length: 0,
        })
        .collect()
}

impl Dialect for Auto {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        self.heard_bytes += bytes.len() as u64;
        self.heard_since_frame |= !bytes.is_empty();
        match &mut self.spoken {
            Some(spoken) => {
                let before = decoded.len();
                spoken.feed(now_ns, bytes, decoded);
                let has_frame = |one: &Decoded| matches!(one, Decoded::Frame(_));
                if decoded[before..].iter().any(has_frame) {
                    self.frame_ns = now_ns;
                    self.heard_since_frame = false;
                }
            }
            None => {
                for candidate in &mut self.candidates {
                    candidate.feed(now_ns, bytes);
                }
                self.choose(now_ns, decoded);
            }
        }
        decoded.extend(self.notes.drain(..).map(Decoded::Note));
    }

    fn say(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        if let Some(spoken) = &mut self.spoken {
            if self.heard_since_frame && now_ns.saturating_sub(self.frame_ns) > LISTEN_NS {
                self.notes
                    .push("what comes is no frame any more: listening anew".to_owned());
                self.listen_anew(now_ns);
                return None;
            }
            return spoken.say(now_ns);
        }
        let listened_ns = now_ns.saturating_sub(self.since_ns);
        if listened_ns < LISTEN_NS {
            return None;
        }
        let heard = self.heard_bytes;
        if !self.announced {
            self.announced = true;
            let names: Vec<&str> = COMMANDS.iter().map(|(_, _, name)| *name).collect();
            self.notes.push(format!(
                "{heard} bytes in {} s and no frame among them: sending {}, one after the other",
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
                    "no frame in any known format ({heard} bytes came): still listening; `gelpad listen` shows what comes, --format names a format"
                ));
            }
            return None;
        }
        self.tried += 1;
        tracing::debug!("trying {}", kind.name());
        Some(command.to_vec())
    }

    fn reopened(&mut self) {
        match &mut self.spoken {
            Some(spoken) => spoken.reopened(),
            None => self.listen_anew(0),
        }
        self.frame_ns = 0;
        self.heard_since_frame = false;
    }

    fn farewell(&self) -> &'static [u8] {
        match &self.spoken {
            Some(spoken) => spoken.farewell(),
            None => &[],
        }
    }

    fn held_bytes(&self) -> usize {
        let run = |candidate: &Candidate| -> usize {
            candidate.run.len() * candidate.length * 4 + candidate.dialect.held_bytes()
        };
        self.candidates.iter().map(run).sum::<usize>()
            + self.spoken.as_ref().map_or(0, |spoken| spoken.held_bytes())
    }

    fn kind(&self) -> Option<FormatKind> {
        self.spoken.as_ref()?.kind()
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
    fn each_format_is_told_by_its_frames_and_none_is_lost() {
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
        let cases: [(FormatKind, Vec<u8>, usize); 6] = [
            (
                FormatKind::Gelpad,
                gelpad::encode(gelpad::Values::F32, 1, 1, part),
                1,
            ),
            (FormatKind::Sciospec, rows, 2),
            (FormatKind::OpenEit, openeit::encode(part).into_bytes(), 2),
            (FormatKind::Request, request::encode(part).into_bytes(), 1),
            (FormatKind::Square, square::encode(&values).into_bytes(), 3),
            (
                FormatKind::Lines,
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
    fn a_silent_board_is_sent_the_start_commands_after_it_was_said() {
        let mut board = auto();
        let mut decoded = Vec::new();
        assert_eq!(board.say(LISTEN_NS - 1), None);
        assert_eq!(board.say(LISTEN_NS), None, "first it is said");
        board.feed(LISTEN_NS, b"", &mut decoded);
        assert_eq!(
            notes(&decoded),
            [
                "0 bytes in 3 s and no frame among them: sending the menu choice `c`, the request `D`, Sciospec's start, one after the other"
            ]
        );
        let sent: Vec<Vec<u8>> = (0..200)
            .filter_map(|step| board.say(LISTEN_NS + step * ANSWER_NS / 10))
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
    fn another_format_in_mid_stream_is_listened_to_anew() {
        let mut board = auto();
        let mut decoded = Vec::new();
        let packet = gelpad::encode(gelpad::Values::F32, 1, 1, &[1.0; 208]);
        board.feed(0, &packet, &mut decoded);
        let line = openeit::encode(&[2.0; 208]);
        board.feed(LISTEN_NS / 2, line.as_bytes(), &mut decoded);
        board.feed(LISTEN_NS, line.as_bytes(), &mut decoded);
        assert_eq!(board.say(LISTEN_NS + 1), None);
        assert_eq!(board.kind(), None);
        for _ in 0..2 {
            board.feed(LISTEN_NS + 2, line.as_bytes(), &mut decoded);
        }
        assert_eq!(board.kind(), Some(FormatKind::OpenEit));
        assert_eq!(frames(&decoded).len(), 3);
    }
}
