//! N x N text, as sent by the Teensy boards: one line of all pairs, `%.4f, ` each, then `\n`; drives outer,
//! measurements inner. Driven pairs are not measured and hold arbitrary values, which the arrangement drops.

use super::early::{EarlyWords, WordRule};
use super::text::{LineBuffer, number, numbers, same_decimals};
use super::{Decoded, Dialect, FEWEST_VALUES, WireFormat};
use crate::types::Nanos;

/// Numbers of electrodes of these boards.
const ELECTRODES: [usize; 3] = [8, 16, 32];

/// Decoder of the format.
#[derive(Clone, Debug, Default)]
pub struct Square {
    line: LineBuffer,
    early: EarlyWords,
}

impl Dialect for Square {
    fn feed(&mut self, _: Nanos, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        let rule = WordRule {
            is_separator: &|byte| byte == b',',
            may_repeat: false,
            parse: &|_, word| number(word).ok(),
        };
        let parse =
            |text: &str| (text.matches(',').count() >= FEWEST_VALUES).then(|| parse_line(text));
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
        Some(WireFormat::Square)
    }
}

fn parse_line(text: &str) -> Result<Vec<f32>, String> {
    let text = text.trim_end();
    let text = text.strip_suffix(',').unwrap_or(text);
    same_decimals(text.split(','))?;
    let values = numbers(text.split(','))?;
    if ELECTRODES.iter().any(|n| n * n == values.len()) {
        Ok(values)
    } else {
        Err(format!(
            "{} values; all pairs of 8, 16 or 32 electrodes are 64, 256 or 1024",
            values.len()
        ))
    }
}

/// A frame as the firmware prints it, rounded to four decimals.
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

    fn decode_all(bytes: &[u8]) -> Vec<Decoded> {
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
        let decoded = decode_all(format!("hello\n{one_less}{cut_digit}{merged}{line}").as_bytes());
        assert_eq!(
            reasons(&decoded),
            [
                "63 values; all pairs of 8, 16 or 32 electrodes are 64, 256 or 1024",
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
            prop_assert_eq!(frames(&decode_all(encode(&values).as_bytes())), vec![expected]);
        }
    }
}
