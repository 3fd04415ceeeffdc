//! A line of numbers a frame, whatever stands between them: what most boards made at a bench send.
//!
//! Numbers are split at commas, semicolons, bars, tabs and blanks; what stands before the last `:` is a label. With
//! `lines:complex` real and imaginary parts take turns, and a value is their magnitude with the sign of the real part,
//! so that the order can be recognised. A line with a word among many numbers is garbled; one with few is a message.

use super::text::{LineBuffer, numbers};
use super::{Decoded, Dialect, FEWEST_VALUES, FormatKind, WireFrame};
use crate::types::Nanos;

/// What may stand between numbers.
const SEPARATORS: [char; 5] = [',', ';', '|', '\t', ' '];

/// Reads the format from bytes.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    line: LineBuffer,
    complex: bool,
}

impl Lines {
    /// A decoder; `complex` where real and imaginary parts take turns.
    #[must_use]
    pub fn new(complex: bool) -> Self {
        Self {
            line: LineBuffer::default(),
            complex,
        }
    }
}

impl Dialect for Lines {
    fn feed(&mut self, _: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        let complex = self.complex;
        self.line.feed(bytes, |line, raw| match line {
            Err(no_text) => decoded.push(Decoded::garbled(no_text.reason(), raw)),
            Ok(text) => match values_of(text, complex) {
                Some(Ok(values)) => decoded.push(Decoded::Frame(WireFrame::of(values))),
                Some(Err(reason)) => decoded.push(Decoded::garbled(reason, raw)),
                None => {}
            },
        });
    }

    fn reopened(&mut self) {
        self.line.clear();
    }

    fn held_bytes(&self) -> usize {
        self.line.held_bytes()
    }

    fn kind(&self) -> Option<FormatKind> {
        Some(FormatKind::Lines)
    }
}

fn values_of(text: &str, complex: bool) -> Option<Result<Vec<f32>, String>> {
    let text = text.rsplit(':').next().unwrap_or(text);
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

fn signed_magnitude(real: f32, imaginary: f32) -> f32 {
    let [re, im] = [real, imaginary].map(f64::from);
    libm::copysign(libm::sqrt(re * re + im * im), re) as f32
}

/// A frame with all the digits that a value has: decoding gives the same bits.
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

    fn fed(complex: bool, bytes: &[u8]) -> Vec<Decoded> {
        let mut decoded = Vec::new();
        Lines::new(complex).feed(0, bytes, &mut decoded);
        decoded
    }

    #[test]
    fn any_separator_will_do() {
        for text in [
            "1,2,3,4,-5.5\n",
            "1;2;3;4;-5.5;\r\n",
            "1\t2\t3\t4\t-5.5\n",
            " 1  2 3 4   -5.5 \n",
            "1 | 2 | 3 | 4 | -5.5\n",
            "frame 7: 1, 2, 3, 4, -5.5,\n",
        ] {
            assert_eq!(
                frames(&fed(false, text.as_bytes())),
                [vec![1.0, 2.0, 3.0, 4.0, -5.5]],
                "{text:?}"
            );
        }
    }

    #[test]
    fn parts_become_magnitudes_with_the_sign_of_the_real_part() {
        let decoded = fed(true, b"3,4,-3,4,0,1,5,0,-5,0\n1,2,3,4,5\n");
        assert_eq!(frames(&decoded), [vec![5.0, -5.0, 1.0, 5.0, -5.0]]);
        assert_eq!(
            reasons(&decoded),
            ["5 numbers: a real or an imaginary part is missing"]
        );
    }

    #[test]
    fn messages_pass_and_words_among_numbers_do_not() {
        let decoded = fed(false, b"gain 10, range 5\n\n1,2,3,4,5,six\n1,2,3,4,5\n");
        assert_eq!(reasons(&decoded), ["\"six\" is no value"]);
        assert_eq!(frames(&decoded).len(), 1);
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded_bit_for_bit(
            values in proptest::collection::vec(proptest::num::f32::NORMAL, 5..40),
            complex: bool,
        ) {
            let decoded = fed(complex, encode(&values, complex).as_bytes());
            prop_assert_eq!(frames(&decoded), vec![values]);
        }
    }
}
