//! Request and reply, as used by the ESP32-S2 boards: the host sends `D`, the board answers with one value a
//! line (`%.5f`), then `Done`.
//!
//! The next request is sent when a reply is complete, so the board sets the pace. If a request or a reply is lost, both
//! sides wait: the request is repeated after a second of silence. Text before the first value is a message.

use super::text::{InvalidLine, LineBuffer, decimals, number};
use super::{
    Decoded, Dialect, FEWEST_VALUES, MOST_VALUES, Readings, SHOWN_BYTES, WireFormat, WireFrame,
};
use crate::types::{NANOS_PER_MS, Nanos};

/// The request.
pub const REQUEST: &[u8] = b"D";
/// The end of a reply.
const DONE: &str = "Done";
/// Silence after which a request is repeated. A board measures all its readings before it answers.
const REPEAT_NS: Nanos = 1000 * NANOS_PER_MS;

/// Decoder of the format, which also sends requests.
#[derive(Clone, Debug, Default)]
pub struct Request {
    lines: LineBuffer,
    values: Vec<f32>,
    decimals: usize,
    /// Why the present reply is garbled, and the line that shows it.
    garbled: Option<(String, Vec<u8>)>,
    is_waiting: bool,
    hands_up: bool,
    /// Values of the present reply that were handed up.
    handed_up: usize,
    /// When bytes last arrived or a request was sent.
    quiet_since_ns: Nanos,
}

impl Request {
    fn take_line(
        &mut self,
        line: Result<&str, InvalidLine>,
        raw: &[u8],
        decoded: &mut Vec<Decoded>,
    ) {
        let text = match line {
            Ok(text) => text.trim(),
            Err(no_text) => return self.mark_garbled(no_text.reason().to_owned(), raw),
        };
        if text == DONE {
            self.is_waiting = false;
            self.handed_up = 0;
            let values = std::mem::take(&mut self.values);
            decoded.push(match self.garbled.take() {
                Some((reason, bytes)) => Decoded::Garbled { reason, bytes },
                None if values.len() < FEWEST_VALUES => {
                    Decoded::garbled(format!("a reply of only {} values", values.len()), raw)
                }
                None => Decoded::Frame(WireFrame::from_values(values)),
            });
            return;
        }
        match number(text) {
            Ok(_) if self.values.len() == MOST_VALUES => {
                self.mark_garbled(format!("a reply of more than {MOST_VALUES} values"), raw);
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
                    self.mark_garbled(reason, raw);
                }
                self.values.push(value);
            }
            // A message before the reply: some boards print at reset.
            Err(_) if self.values.is_empty() => {}
            Err(reason) => self.mark_garbled(reason, raw),
        }
    }

    /// Marks the reply as garbled.
    fn mark_garbled(&mut self, reason: String, raw: &[u8]) {
        let shown = &raw[..raw.len().min(SHOWN_BYTES)];
        self.garbled.get_or_insert_with(|| (reason, shown.to_vec()));
    }
}

impl Dialect for Request {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        if !bytes.is_empty() {
            self.quiet_since_ns = now_ns;
        }
        let mut buffer = std::mem::take(&mut self.lines);
        buffer.feed(bytes, |line, raw| self.take_line(line, raw, decoded));
        self.lines = buffer;
        if self.hands_up && self.garbled.is_none() && self.values.len() > self.handed_up {
            let fresh = self.values[self.handed_up..].to_vec();
            let readings = Readings::from_values(self.handed_up, fresh);
            decoded.push(Decoded::Readings(readings));
            self.handed_up = self.values.len();
        }
    }

    fn hand_up_readings(&mut self) {
        self.hands_up = true;
    }

    fn poll_command(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        if self.is_waiting && now_ns.saturating_sub(self.quiet_since_ns) < REPEAT_NS {
            return None;
        }
        self.is_waiting = true;
        self.quiet_since_ns = now_ns;
        // An incomplete reply is not part of the next one.
        self.lines.clear();
        self.values.clear();
        self.handed_up = 0;
        self.garbled = None;
        Some(REQUEST.to_vec())
    }

    fn reopened(&mut self) {
        *self = Self {
            hands_up: self.hands_up,
            ..Self::default()
        };
    }

    fn held_bytes(&self) -> usize {
        self.lines.held_bytes() + size_of_val(self.values.as_slice())
    }

    fn kind(&self) -> Option<WireFormat> {
        Some(WireFormat::Request)
    }
}

/// A reply as the firmware prints it, rounded to five decimals.
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
    fn a_request_follows_a_complete_reply_and_a_lost_one_is_repeated() {
        let mut board = Request::default();
        let mut decoded = Vec::new();
        assert_eq!(board.poll_command(0), Some(REQUEST.to_vec()));
        assert_eq!(board.poll_command(SECOND / 2), None);
        board.feed(SECOND / 2, b"ready\r\n1.00000\r\n2.00000\r\n", &mut decoded);
        assert_eq!(board.poll_command(SECOND), None, "a reply is coming in");
        assert_eq!(board.poll_command(SECOND * 3 / 2), Some(REQUEST.to_vec()));
        let reply = encode(&[3.0, 4.0, 5.0, 6.0, 7.0]);
        board.feed(SECOND * 2, reply.as_bytes(), &mut decoded);
        assert_eq!(board.poll_command(SECOND * 2), Some(REQUEST.to_vec()));
        assert_eq!(frames(&decoded), [vec![3.0, 4.0, 5.0, 6.0, 7.0]]);
    }

    #[test]
    fn a_damaged_reply_is_reported_once_and_the_next_is_decoded() {
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
