//! Request and reply, as of the ESP32-S2 boards: the host sends `D`, the board answers a value a line (`%.5f`), then
//! `Done`.
//!
//! The next request goes out as soon as a reply is whole, so the board sets the pace. A request or reply that got lost
//! leaves both sides waiting: after a second of silence it is sent again. Text before the first value is a message.

use super::text::{LineBuffer, NoText, decimals, number};
use super::{Decoded, Dialect, FEWEST_VALUES, FormatKind, MOST_VALUES, SHOWN_BYTES, WireFrame};
use crate::types::{NANOS_PER_MS, Nanos};

/// What the host sends.
pub const REQUEST: &[u8] = b"D";
/// What ends a reply.
const DONE: &str = "Done";
/// Silence after which a request is sent again. A board measures all its readings before it answers.
const PATIENCE_NS: Nanos = 1000 * NANOS_PER_MS;

/// Reads the format from bytes, and asks.
#[derive(Clone, Debug, Default)]
pub struct Request {
    line: LineBuffer,
    values: Vec<f32>,
    decimals: usize,
    /// Why the reply that comes in is garbled, and the line that made it so.
    garbled: Option<(String, Vec<u8>)>,
    asked: bool,
    /// When something last came or was asked for.
    quiet_since_ns: Nanos,
}

impl Request {
    fn line(&mut self, line: Result<&str, NoText>, raw: &[u8], decoded: &mut Vec<Decoded>) {
        let text = match line {
            Ok(text) => text.trim(),
            Err(no_text) => return self.spoil(no_text.reason().to_owned(), raw),
        };
        if text == DONE {
            self.asked = false;
            let values = std::mem::take(&mut self.values);
            decoded.push(match self.garbled.take() {
                Some((reason, bytes)) => Decoded::Garbled { reason, bytes },
                None if values.len() < FEWEST_VALUES => Decoded::garbled(
                    format!("a reply of {} values: that is no frame", values.len()),
                    raw,
                ),
                None => Decoded::Frame(WireFrame::of(values)),
            });
            return;
        }
        match number(text) {
            Ok(_) if self.values.len() == MOST_VALUES => {
                self.spoil(format!("a reply of more than {MOST_VALUES} values"), raw);
            }
            Ok(value) => {
                if self.values.is_empty() {
                    self.decimals = decimals(text);
                } else if decimals(text) != self.decimals {
                    let here = decimals(text);
                    let reason = format!(
                        "values with {} and with {here} decimals: digits were lost",
                        self.decimals
                    );
                    self.spoil(reason, raw);
                }
                self.values.push(value);
            }
            // A message before the reply: not every board is silent at reset.
            Err(_) if self.values.is_empty() => {}
            Err(reason) => self.spoil(reason, raw),
        }
    }

    /// The reply is no frame, whatever else comes of it.
    fn spoil(&mut self, reason: String, raw: &[u8]) {
        let shown = &raw[..raw.len().min(SHOWN_BYTES)];
        self.garbled.get_or_insert_with(|| (reason, shown.to_vec()));
    }
}

impl Dialect for Request {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        if !bytes.is_empty() {
            self.quiet_since_ns = now_ns;
        }
        let mut buffer = std::mem::take(&mut self.line);
        buffer.feed(bytes, |line, raw| self.line(line, raw, decoded));
        self.line = buffer;
    }

    fn say(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        if self.asked && now_ns.saturating_sub(self.quiet_since_ns) < PATIENCE_NS {
            return None;
        }
        self.asked = true;
        self.quiet_since_ns = now_ns;
        // What came of a reply that stopped is no part of the next one.
        self.line.clear();
        self.values.clear();
        self.garbled = None;
        Some(REQUEST.to_vec())
    }

    fn reopened(&mut self) {
        *self = Self::default();
    }

    fn held_bytes(&self) -> usize {
        self.line.held_bytes() + size_of_val(self.values.as_slice())
    }

    fn kind(&self) -> Option<FormatKind> {
        Some(FormatKind::Request)
    }
}

/// A reply as the firmware prints it. Values are rounded to five decimals.
#[must_use]
pub fn encode(values: &[f32]) -> String {
    use std::fmt::Write as _;
    let mut reply = String::with_capacity(values.len() * 10);
    for value in values {
        let _ = write!(reply, "{value:.5}\r\n");
    }
    reply.push_str(DONE);
    reply.push_str("\r\n");
    reply
}

#[cfg(test)]
mod tests {
    use super::super::tests_support::{frames, reasons};
    use super::*;
    use proptest::prelude::*;

    const SECOND: Nanos = 1000 * NANOS_PER_MS;

    #[test]
    fn a_request_follows_a_whole_reply_and_a_lost_one_is_repeated() {
        let mut board = Request::default();
        let mut decoded = Vec::new();
        assert_eq!(board.say(0), Some(REQUEST.to_vec()));
        assert_eq!(board.say(SECOND / 2), None);
        board.feed(SECOND / 2, b"ready\r\n1.00000\r\n2.00000\r\n", &mut decoded);
        assert_eq!(board.say(SECOND), None, "a reply is coming in");
        assert_eq!(board.say(SECOND * 3 / 2), Some(REQUEST.to_vec()));
        let reply = encode(&[3.0, 4.0, 5.0, 6.0, 7.0]);
        board.feed(SECOND * 2, reply.as_bytes(), &mut decoded);
        assert_eq!(board.say(SECOND * 2), Some(REQUEST.to_vec()));
        assert_eq!(frames(&decoded), [vec![3.0, 4.0, 5.0, 6.0, 7.0]]);
    }

    #[test]
    fn a_damaged_reply_is_said_once_and_the_next_is_read_right() {
        let reply = encode(&[1.5; 6]);
        let mut board = Request::default();
        let mut decoded = Vec::new();
        let damaged = [
            reply.replacen("1.50000\r\n1.50000", "1.500001.50000", 1),
            reply.replacen("1.50000", "1.5000", 2),
            reply.replacen("\n1.50000", "\n1.5x000", 2),
            "Done\r\n".to_owned(),
        ];
        for text in &damaged {
            board.feed(0, text.as_bytes(), &mut decoded);
        }
        board.feed(0, reply.as_bytes(), &mut decoded);
        assert_eq!(reasons(&decoded).len(), damaged.len(), "{decoded:?}");
        assert_eq!(frames(&decoded), [vec![1.5; 6]]);
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded(values in proptest::collection::vec(-1e3..1e3f32, 5..40)) {
            let mut decoded = Vec::new();
            Request::default().feed(0, encode(&values).as_bytes(), &mut decoded);
            let expected: Vec<f32> = values
                .iter()
                .map(|value| format!("{value:.5}").parse().expect("a number"))
                .collect();
            prop_assert_eq!(frames(&decoded), vec![expected]);
        }
    }
}
