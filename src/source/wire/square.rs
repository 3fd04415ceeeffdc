//! N x N text, as of the Teensy boards: a line of all pairs, `%.4f, ` each, then `\n`; drives outer, measurements
//! inner. Driven pairs are not measured and hold zeros or what was there before: whoever arranges the frame drops them.

use super::text::{LineBuffer, numbers, same_decimals};
use super::{Decoded, Dialect, FEWEST_VALUES, FormatKind, WireFrame};
use crate::types::Nanos;

/// Electrodes of boards that send so.
const ELECTRODES: [usize; 3] = [8, 16, 32];

/// Reads the format from bytes.
#[derive(Clone, Debug, Default)]
pub struct Square {
    line: LineBuffer,
}

impl Dialect for Square {
    fn feed(&mut self, _: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        self.line.feed(bytes, |line, raw| match line {
            Err(no_text) => decoded.push(Decoded::garbled(no_text.reason(), raw)),
            Ok(text) if text.matches(',').count() < FEWEST_VALUES => {}
            Ok(text) => decoded.push(match values_of(text) {
                Ok(values) => Decoded::Frame(WireFrame::of(values)),
                Err(reason) => Decoded::garbled(reason, raw),
            }),
        });
    }

    fn reopened(&mut self) {
        self.line.clear();
    }

    fn held_bytes(&self) -> usize {
        self.line.held_bytes()
    }

    fn kind(&self) -> Option<FormatKind> {
        Some(FormatKind::Square)
    }
}

fn values_of(text: &str) -> Result<Vec<f32>, String> {
    let text = text.trim_end();
    let text = text.strip_suffix(',').unwrap_or(text);
    same_decimals(text.split(','))?;
    let values = numbers(text.split(','))?;
    if ELECTRODES.iter().any(|n| n * n == values.len()) {
        Ok(values)
    } else {
        Err(format!(
            "{} values where all pairs of 8, 16 or 32 electrodes are 64, 256 or 1024",
            values.len()
        ))
    }
}

/// A frame as the firmware prints it. Values are rounded to four decimals.
#[must_use]
pub fn encode(values: &[f32]) -> String {
    use std::fmt::Write as _;
    let mut line = String::with_capacity(values.len() * 9);
    for value in values {
        let _ = write!(line, "{value:.4}, ");
    }
    line.push('\n');
    line
}

#[cfg(test)]
mod tests {
    use super::super::tests_support::{frames, reasons};
    use super::*;
    use proptest::prelude::*;

    fn fed(bytes: &[u8]) -> Vec<Decoded> {
        let mut decoded = Vec::new();
        Square::default().feed(0, bytes, &mut decoded);
        decoded
    }

    #[test]
    fn a_line_with_another_count_or_lost_digits_is_garbled() {
        let line = encode(&[1.25; 64]);
        let one_less = line.replacen("1.2500, ", "", 1);
        let cut_digit = line.replacen("1.2500", "1.250", 1);
        let merged = line.replacen("1.2500, 1.2500", "1.25001.2500", 1);
        let decoded = fed(format!("hello\n{one_less}{cut_digit}{merged}{line}").as_bytes());
        assert_eq!(
            reasons(&decoded),
            [
                "63 values where all pairs of 8, 16 or 32 electrodes are 64, 256 or 1024",
                "values with 3 and with 4 decimals: digits were lost",
                "values with 10 and with 4 decimals: digits were lost",
            ]
        );
        assert_eq!(frames(&decoded), [vec![1.25; 64]]);
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded(values in proptest::collection::vec(-1e3..1e3f32, 64)) {
            let expected: Vec<f32> = values
                .iter()
                .map(|value| format!("{value:.4}").parse().expect("a number"))
                .collect();
            prop_assert_eq!(frames(&fed(encode(&values).as_bytes())), vec![expected]);
        }
    }
}
