//! OpenEIT Spectra's text: a line `magnitudes: `, the values `%8d.%04d` each with a comma behind it, `\r\n`.
//!
//! Read in the firmware: the tag is also seen as `magnitudes : `; a line is cut at its first `:` and then at its
//! commas. Some boards print a menu at reset and wait for a choice: where nothing comes, [`CHOICE`] asks for images.
//! Lines with another tag (the menu, messages) are no frames and pass in silence. A line that has the tag but whose
//! values are not all whole is garbled: every value is printed at least 13 characters wide, so a lost byte shows.

use super::text::{LineBuffer, number};
use super::{Decoded, Dialect, FEWEST_VALUES, FormatKind, MOST_VALUES, WireFrame};
use crate::types::{NANOS_PER_MS, Nanos};

/// What a line of values begins with.
const TAG: &str = "magnitudes";
/// Characters of a value, blanks included: `%8d.%04d`.
const WIDTH: usize = 13;
/// What is chosen from the menu: tetrapolar imaging.
pub const CHOICE: &[u8] = b"c\n";
/// A menu waits: after so long without a frame the choice is made, and again.
const MENU_WAIT_NS: Nanos = 1000 * NANOS_PER_MS;

/// Reads the format from bytes.
#[derive(Clone, Debug, Default)]
pub struct OpenEit {
    line: LineBuffer,
    /// When a frame last came, or the choice was last made.
    quiet_since_ns: Nanos,
}

impl Dialect for OpenEit {
    fn feed(&mut self, now_ns: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        let quiet_since_ns = &mut self.quiet_since_ns;
        self.line.feed(bytes, |line, raw| {
            let garbled = |reason: &str| Decoded::garbled(reason, raw);
            match line {
                Err(no_text) => decoded.push(garbled(no_text.reason())),
                Ok(text) => match values_of(text) {
                    Some(Ok(values)) => {
                        *quiet_since_ns = now_ns;
                        decoded.push(Decoded::Frame(WireFrame::of(values)));
                    }
                    Some(Err(reason)) => decoded.push(garbled(&reason)),
                    None => {}
                },
            }
        });
    }

    fn say(&mut self, now_ns: Nanos) -> Option<Vec<u8>> {
        if now_ns.saturating_sub(self.quiet_since_ns) < MENU_WAIT_NS {
            return None;
        }
        self.quiet_since_ns = now_ns;
        Some(CHOICE.to_vec())
    }

    fn reopened(&mut self) {
        self.line.clear();
        self.quiet_since_ns = 0;
    }

    fn held_bytes(&self) -> usize {
        self.line.held_bytes()
    }

    fn kind(&self) -> Option<FormatKind> {
        Some(FormatKind::OpenEit)
    }
}

/// The values of a line, or why they are none; nothing for a line that is no frame.
fn values_of(text: &str) -> Option<Result<Vec<f32>, String>> {
    // A line cut in its tag still holds commas; a message of the board's does not look like values.
    let Some((tag, values)) = text.split_once(':') else {
        let commas = text.matches(',').count();
        return (commas > 1)
            .then(|| Err(format!("a line without its beginning ({commas} commas)")));
    };
    if tag.trim() != TAG {
        let is_frame = tag.contains(TAG) || values.matches(',').count() > 1;
        let short: String = tag.trim().chars().take(20).collect();
        return is_frame.then(|| Err(format!("a line of values tagged {short:?}")));
    }
    Some(values_behind_tag(values))
}

fn values_behind_tag(text: &str) -> Result<Vec<f32>, String> {
    let text = text.trim_end();
    let Some(text) = text.strip_suffix(',') else {
        return Err("a line that is cut: no comma at its end".to_owned());
    };
    let text = text.strip_prefix(' ').unwrap_or(text);
    let is_padded = text
        .split(',')
        .any(|word| word.starts_with(' ') && word.len() == WIDTH);
    let mut values = Vec::with_capacity(256);
    for word in text.split(',') {
        if is_padded && word.len() < WIDTH {
            return Err(format!(
                "a value of {} characters where the others have {WIDTH}: bytes were lost",
                word.len()
            ));
        }
        if values.len() == MOST_VALUES {
            return Err(format!("more than {MOST_VALUES} values"));
        }
        values.push(number(word)?);
    }
    if values.len() < FEWEST_VALUES {
        return Err(format!("{} values: that is no frame", values.len()));
    }
    Ok(values)
}

/// A frame as the firmware prints it. Values are rounded to four decimals.
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

    fn fed(chunks: &[&[u8]]) -> Vec<Decoded> {
        let mut decoder = OpenEit::default();
        let mut decoded = Vec::new();
        for chunk in chunks {
            decoder.feed(0, chunk, &mut decoded);
        }
        decoded
    }

    #[test]
    fn the_firmwares_line_is_read_in_any_pieces() {
        let line = b"magnitudes:        1.5000,       2.0000,    -300.2500,       4.0000,       5.0000,\r\n";
        let values = vec![vec![1.5, 2.0, -300.25, 4.0, 5.0]];
        assert_eq!(frames(&fed(&[line])), values);
        let bytes: Vec<&[u8]> = line.chunks(1).collect();
        assert_eq!(frames(&fed(&bytes)), values);
        assert_eq!(
            frames(&fed(&[b"magnitudes : 1.5,2,-300.25,4,5,\n"])),
            values
        );
    }

    #[test]
    fn menus_and_messages_pass_in_silence() {
        assert_eq!(
            fed(&[b"Select mode:\r\n 1) imaging\r\n\r\nstarting\r\n"]),
            []
        );
    }

    #[test]
    fn a_menu_that_waits_gets_its_choice_once_a_second() {
        let mut board = OpenEit::default();
        let ms = |t| t * NANOS_PER_MS;
        assert_eq!(board.say(ms(900)), None);
        assert_eq!(board.say(ms(1000)), Some(CHOICE.to_vec()));
        assert_eq!(board.say(ms(1900)), None);
        assert_eq!(board.say(ms(2000)), Some(CHOICE.to_vec()));
        board.feed(ms(2500), encode(&[1.0; 16]).as_bytes(), &mut Vec::new());
        assert_eq!(
            board.say(ms(3400)),
            None,
            "a board that sends is left alone"
        );
    }

    #[test]
    fn garbled_lines_are_said_and_the_next_is_read_right() {
        let decoded = fed(&[
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
                "2 values: that is no frame",
                "\"2.x\" is no value",
                "a line that is cut: no comma at its end",
                "a value of 12 characters where the others have 13: bytes were lost",
                "a line of values tagged \"des\"",
                "a line without its beginning (3 commas)",
                "a line that is no text: is the baud rate right?",
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
            prop_assert_eq!(frames(&fed(&[encode(&values).as_bytes()])), vec![expected]);
        }

        #[test]
        fn a_lost_byte_never_makes_a_frame_of_other_values(
            values in proptest::collection::vec(0.0..1e6f32, 16),
            lost in 0usize..16 * 14,
        ) {
            let mut line = encode(&values).into_bytes();
            let whole = frames(&fed(&[&line]));
            line.remove(lost);
            let damaged = frames(&fed(&[&line, b"\n"]));
            // A blank less before the first value changes nothing.
            prop_assert!(damaged.is_empty() || damaged == whole, "{:?}", damaged);
        }
    }
}
