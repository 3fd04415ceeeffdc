//! One line of numbers for each frame: what most boards built in a lab send.
//!
//! Numbers are separated by commas, semicolons, bars, tabs or blanks, and may stand in brackets; text before the last `:` is
//! a label. Where something else separates the numbers, a comma within one is its decimal point.
//! With `lines:complex` real and imaginary parts alternate, and a value is their magnitude with the sign of
//! the real part, so that the order can be recognised. A line with a word among many numbers is garbled; a
//! line with few numbers is a message.

use super::early::{EarlyWords, WordRule};
use super::text::{LineBuffer, number, numbers};
use super::{Decoded, Dialect, FEWEST_VALUES, WireFormat};
use crate::types::Nanos;

/// Separators of numbers; brackets around them have no meaning.
const SEPARATORS: [char; 11] = [',', ';', '|', '\t', ' ', '[', ']', '(', ')', '{', '}'];

/// Decoder of the format.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    line: LineBuffer,
    early: EarlyWords,
    complex: bool,
}

impl Lines {
    /// A decoder; `complex` if real and imaginary parts alternate.
    #[must_use]
    pub fn new(complex: bool) -> Self {
        Self {
            complex,
            ..Self::default()
        }
    }
}

impl Dialect for Lines {
    fn feed(&mut self, _: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        let complex = self.complex;
        let rule = WordRule {
            is_separator: &|byte| SEPARATORS.contains(&char::from(byte)),
            may_repeat: true,
            // A complex value is two words: such lines are read when they end.
            parse: &|_, word| number(word).ok().filter(|_| !complex),
        };
        let parse = |text: &str| parse_line(text, complex);
        self.line
            .decode(bytes, decoded, parse, (&mut self.early, &rule));
    }

    fn hand_up_readings(&mut self) {
        self.early.switch_on();
    }

    fn reopened(&mut self) {
        self.line.clear();
        self.early.clear();
    }

    fn held_bytes(&self) -> usize {
        self.line.held_bytes() + self.early.held_bytes()
    }

    fn kind(&self) -> Option<WireFormat> {
        Some(WireFormat::Lines)
    }
}

fn parse_line(text: &str, complex: bool) -> Option<Result<Vec<f32>, String>> {
    let text = text.rsplit(':').next().unwrap_or(text);
    let with_points;
    let text = match has_decimal_commas(text) {
        true => {
            with_points = text.replace(',', ".");
            &with_points
        }
        false => text,
    };
    let words = || text.split(SEPARATORS).filter(|word| !word.is_empty());
    let looks_like_numbers = words()
        .filter(|word| {
            word.starts_with(|first: char| first.is_ascii_digit() || "+-.".contains(first))
        })
        .take(FEWEST_VALUES)
        .count()
        == FEWEST_VALUES;
    if !looks_like_numbers {
        return None;
    }
    let values = match numbers(words()) {
        Ok(values) => values,
        Err(reason) => return Some(Err(reason)),
    };
    if !complex {
        return Some(Ok(values));
    }
    if !values.len().is_multiple_of(2) {
        return Some(Err(format!(
            "{} numbers: a real or an imaginary part is missing",
            values.len()
        )));
    }
    Some(Ok(values
        .chunks_exact(2)
        .map(|part| signed_magnitude(part[0], part[1]))
        .collect()))
}

/// Whether most numbers are written as `1,5`, with something else between them. A counter has no comma.
fn has_decimal_commas(text: &str) -> bool {
    if text.contains('.') || !text.contains(',') {
        return false;
    }
    let is_separator = |one: char| one != ',' && SEPARATORS.contains(&one);
    let (mut with_comma, mut others) = (0, 0);
    for word in text.split(is_separator).filter(|word| !word.is_empty()) {
        let digits = |part: &str| part.bytes().next().is_some_and(|one| one.is_ascii_digit());
        match word.split_once(',') {
            Some((whole, decimals)) => {
                let whole = whole.trim_start_matches(['+', '-']);
                if !digits(whole) || !digits(decimals) || decimals.contains(',') {
                    return false;
                }
                with_comma += 1;
            }
            None => others += 1,
        }
    }
    with_comma >= FEWEST_VALUES && with_comma > others
}

fn signed_magnitude(real: f32, imaginary: f32) -> f32 {
    let [re, im] = [real, imaginary].map(f64::from);
    libm::copysign(libm::sqrt(re * re + im * im), re) as f32
}

/// A frame with all digits of the values: decoding gives the same bits.
#[must_use]
pub fn encode(values: &[f32], complex: bool) -> String {
    use std::fmt::Write as _;
    let mut line = String::with_capacity(values.len() * 14);
    for (index, value) in values.iter().enumerate() {
        let mark = if index == 0 { "" } else { "," };
        let _ = write!(line, "{mark}{value}");
        if complex {
            line.push_str(",0");
        }
    }
    line.push('\n');
    line
}

#[cfg(test)]
mod tests {
    use super::super::tests_support::{frames, reasons};
    use super::*;
    use proptest::prelude::*;

    fn decode_all(complex: bool, bytes: &[u8]) -> Vec<Decoded> {
        let mut decoded = Vec::new();
        Lines::new(complex).feed(0, bytes, &mut decoded);
        decoded
    }

    #[test]
    fn all_separators_are_accepted() {
        for text in [
            "1,2,3,4,-5.5\n",
            "1;2;3;4;-5.5;\r\n",
            "1\t2\t3\t4\t-5.5\n",
            " 1  2 3 4   -5.5 \n",
            "1 | 2 | 3 | 4 | -5.5\n",
            "frame 7: 1, 2, 3, 4, -5.5,\n",
            "[1, 2, 3, 4, -5.5]\n",
            "[[1.0, 2.0], [3, 4], [-5.5]]\n",
            "1,0;2,0;3,0;4,0;-5,5\n",
            "1,0\t2,0\t3,0\t4,0\t-5,5\r\n",
            "1,0 2,0 3,0 4,0 -5,5\n",
        ] {
            assert_eq!(
                frames(&decode_all(false, text.as_bytes())),
                [vec![1.0, 2.0, 3.0, 4.0, -5.5]],
                "{text:?}"
            );
        }
    }

    #[test]
    fn parts_become_magnitudes_with_the_sign_of_the_real_part() {
        let decoded = decode_all(true, b"3,4,-3,4,0,1,5,0,-5,0\n1,2,3,4,5\n");
        assert_eq!(frames(&decoded), [vec![5.0, -5.0, 1.0, 5.0, -5.0]]);
        assert_eq!(
            reasons(&decoded),
            ["5 numbers: a real or an imaginary part is missing"]
        );
    }

    #[test]
    fn messages_are_ignored_and_words_among_numbers_refused() {
        let decoded = decode_all(false, b"gain 10, range 5\n\n1,2,3,4,5,six\n1,2,3,4,5\n");
        assert_eq!(reasons(&decoded), ["\"six\" is not a number"]);
        assert_eq!(frames(&decoded).len(), 1);
    }

    proptest! {
        #[test]
        fn decoding_restores_every_bit(
            values in proptest::collection::vec(proptest::num::f32::NORMAL, 5..40),
            complex: bool,
        ) {
            let decoded = decode_all(complex, encode(&values, complex).as_bytes());
            prop_assert_eq!(frames(&decoded), vec![values]);
        }
    }
}
