//! OpenEIT Spectra's text: a line `magnitudes: `, the values `%8d.%04d` each with a comma behind it, `\r\n`.
//!
//! The firmware's own reader shows that the tag may also be `magnitudes : `, and that a line is split at its first `:`
//! and then at its commas. Some boards print a menu at reset and wait for a choice: if nothing arrives, [`CHOICE`]
//! selects imaging. Lines with another tag (the menu, messages) are ignored. A line with the tag but incomplete values is
//! garbled: every value is printed at least 13 characters wide, so a lost byte is noticed.

use super::early::{EarlyWords, WordRule};
use super::text::{LineBuffer, number};
use super::{Decoded, Dialect, FEWEST_VALUES, MOST_VALUES, WireFormat};
use crate::types::{NANOS_PER_MS, Nanos};

/// Start of a line of values.
const TAG: &str = "magnitudes";
/// Width of a value with its blanks: `%8d.%04d`.
const WIDTH: usize = 13;
/// The menu choice for tetrapolar imaging.
pub const CHOICE: &[u8] = b"c\n";
/// Time without a frame after which the choice is sent, and repeated.
const MENU_WAIT_NS: Nanos = 1000 * NANOS_PER_MS;

/// Decoder of the format.
#[derive(Clone, Debug, Default)]
pub struct OpenEit {
    line: LineBuffer,
    early: EarlyWords,
    /// When a frame last arrived or the choice was last sent.
    quiet_since_ns: Nanos,
}

impl Dialect for OpenEit {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        let before = decoded.len();
        let rule = WordRule {
            is_separator: &|byte| byte == b',',
            may_repeat: false,
            parse: &parse_early,
        };
        self.line
            .decode(bytes, decoded, parse_line, (&mut self.early, &rule));
        let is_frame = |one: &Decoded| matches!(one, Decoded::Frame(_));
        if decoded[before..].iter().any(is_frame) {
            self.quiet_since_ns = now_ns;
        }
    }

    fn hand_up_readings(&mut self) {
        self.early.switch_on();
    }

    fn poll_command(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        if now_ns.saturating_sub(self.quiet_since_ns) < MENU_WAIT_NS {
            return None;
        }
        self.quiet_since_ns = now_ns;
        Some(CHOICE.to_vec())
    }

    fn reopened(&mut self) {
        self.line.clear();
        self.early.clear();
        self.quiet_since_ns = 0;
    }

    fn held_bytes(&self) -> usize {
        self.line.held_bytes() + self.early.held_bytes()
    }

    fn kind(&self) -> Option<WireFormat> {
        Some(WireFormat::OpenEit)
    }
}

/// The values of a line, or why they are garbled; none for a line that is not a frame.
fn parse_line(text: &str) -> Option<Result<Vec<f32>, String>> {
    // A line that is cut within its tag still holds commas; a message of the board does not look like values.
    let Some((tag, values)) = text.split_once(':') else {
        let commas = text.matches(',').count();
        return (commas > 1).then(|| Err(format!("a line without its start ({commas} commas)")));
    };
    if tag.trim() != TAG {
        let is_frame = tag.contains(TAG) || values.matches(',').count() > 1;
        let short: String = tag.trim().chars().take(20).collect();
        return is_frame.then(|| Err(format!("a line of values tagged {short:?}")));
    }
    Some(parse_values(values))
}

/// The value of a word of a line that is still arriving, which is as wide as the firmware prints it.
fn parse_early(index: usize, word: &str) -> Option<f32> {
    let word = match index {
        0 => {
            let (tag, word) = word.split_once(':')?;
            (tag.trim() == TAG).then_some(word.strip_prefix(' ').unwrap_or(word))?
        }
        _ => word,
    };
    (word.len() >= WIDTH).then(|| number(word).ok())?
}

fn parse_values(text: &str) -> Result<Vec<f32>, String> {
    let text = text.trim_end();
    let Some(text) = text.strip_suffix(',') else {
        return Err("an incomplete line: no comma at its end".to_owned());
    };
    let text = text.strip_prefix(' ').unwrap_or(text);
    let is_padded = text
        .split(',')
        .any(|word| word.starts_with(' ') && word.len() == WIDTH);
    let mut values = Vec::with_capacity(256);
    for word in text.split(',') {
        if is_padded && word.len() < WIDTH {
            return Err(format!(
                "a value of {} characters instead of {WIDTH}: bytes were lost",
                word.len()
            ));
        }
        if values.len() == MOST_VALUES {
            return Err(format!("more than {MOST_VALUES} values"));
        }
        values.push(number(word)?);
    }
    if values.len() < FEWEST_VALUES {
        return Err(format!("only {} values", values.len()));
    }
    Ok(values)
}

/// A frame as the firmware prints it, rounded to four decimals.
#[must_use]
pub fn encode(values: &[f32]) -> String {
    use std::fmt::Write as _;
    let mut line = format!("{TAG}: ");
    for value in values {
        let _ = write!(line, "{value:WIDTH$.4},");
    }
    line.push_str("\r\n");
    line
}

#[cfg(test)]
mod tests {
    use super::super::tests_support::{frames, reasons};
    use super::*;
    use proptest::prelude::*;

    fn decode_all(chunks: &[&[u8]]) -> Vec<Decoded> {
        let mut decoder = OpenEit::default();
        let mut decoded = Vec::new();
        for chunk in chunks {
            decoder.feed(0, chunk, &mut decoded);
        }
        decoded
    }

    #[test]
    fn a_line_is_decoded_in_any_pieces() {
        let line = b"magnitudes:        1.5000,       2.0000,    -300.2500,       4.0000,       5.0000,\r\n";
        let values = vec![vec![1.5, 2.0, -300.25, 4.0, 5.0]];
        assert_eq!(frames(&decode_all(&[line])), values);
        let bytes: Vec<&[u8]> = line.chunks(1).collect();
        assert_eq!(frames(&decode_all(&bytes)), values);
        assert_eq!(
            frames(&decode_all(&[b"magnitudes : 1.5,2,-300.25,4,5,\n"])),
            values
        );
    }

    #[test]
    fn menus_and_messages_are_ignored() {
        assert_eq!(
            decode_all(&[b"Select mode:\r\n 1) imaging\r\n\r\nstarting\r\n"]),
            []
        );
    }

    #[test]
    fn a_waiting_menu_gets_the_choice_once_a_second() {
        let mut board = OpenEit::default();
        let ms = |t| t * NANOS_PER_MS;
        assert_eq!(board.poll_command(ms(900)), None);
        assert_eq!(board.poll_command(ms(1000)), Some(CHOICE.to_vec()));
        assert_eq!(board.poll_command(ms(1900)), None);
        assert_eq!(board.poll_command(ms(2000)), Some(CHOICE.to_vec()));
        board.feed(ms(2500), encode(&[1.0; 16]).as_bytes(), &mut Vec::new());
        assert_eq!(
            board.poll_command(ms(3400)),
            None,
            "a board that sends gets no command"
        );
    }

    #[test]
    fn garbled_lines_are_reported_and_the_next_is_decoded() {
        let decoded = decode_all(&[
            b"magnitudes: 1.0,2.0,\r\n",
            b"magnitudes: 1.0,2.x,3.0,4.0,5.0,\r\n",
            b"magnitudes: 1.0,2.0,3.\r\n",
            b"magnitudes:        1.5000,      2.0000,       3.0000,       4.0000,       5.0000,\r\n",
            b"des: 1.0,2.0,3.0,\r\n",
            b"1.0,2.0,3.0,\r\n",
            b"magnitudes: \xff\xfe,2.0,3.0,\r\n",
            b"magnitudes: 1.0,2.0,3.0,4.0,5.0,\r\n",
        ]);
        assert_eq!(
            reasons(&decoded),
            [
                "only 2 values",
                "\"2.x\" is not a number",
                "an incomplete line: no comma at its end",
                "a value of 12 characters instead of 13: bytes were lost",
                "a line of values tagged \"des\"",
                "a line without its start (3 commas)",
                "a line that is not text: is the baud rate right?",
            ]
        );
        assert_eq!(frames(&decoded), [vec![1.0, 2.0, 3.0, 4.0, 5.0]]);
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded(values in proptest::collection::vec(-1e6..1e6f32, 5..40)) {
            let expected: Vec<f32> = values
                .iter()
                .map(|value| format!("{value:.4}").parse().expect("a number"))
                .collect();
            prop_assert_eq!(frames(&decode_all(&[encode(&values).as_bytes()])), vec![expected]);
        }

        #[test]
        fn a_lost_byte_never_makes_a_frame_of_other_values(
            values in proptest::collection::vec(0.0..1e6f32, 16),
            lost in 0usize..16 * 14,
        ) {
            let mut line = encode(&values).into_bytes();
            let whole = frames(&decode_all(&[&line]));
            line.remove(lost);
            let damaged = frames(&decode_all(&[&line, b"\n"]));
            // A missing blank before the first value changes nothing.
            prop_assert!(damaged.is_empty() || damaged == whole, "{:?}", damaged);
        }
    }
}
