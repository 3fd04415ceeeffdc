//! OpenEIT Spectra's text: a line `magnitudes: `, the values `%8d.%04d` each with a comma behind it, `\r\n`.
//!
//! Read in the firmware: the tag is also seen as `magnitudes : `; a line is cut at its first `:` and then at its
//! commas. Lines with another tag (the menu at reset, messages) are no frames and pass in silence. A line that has
//! the tag but not the pad's number of values, or a value that is no number, is garbled: it is said and skipped, and
//! the next line is read as if nothing had been.

use super::Decoded;

/// What a line of values begins with.
const TAG: &str = "magnitudes";
/// A line longer than this is noise at the wrong baud rate, not text: 256 values of 14 bytes fit four times.
const LONGEST_LINE: usize = 16 * 1024;

/// Reads the format from bytes.
#[derive(Clone, Debug)]
pub struct OpenEit {
    channels: usize,
    line: Vec<u8>,
    overlong: bool,
}

impl OpenEit {
    /// A decoder for frames of so many values.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self {
            channels,
            line: Vec::new(),
            overlong: false,
        }
    }

    /// Takes bytes as they come and appends what the lines that end in them hold.
    pub fn feed(&mut self, bytes: &[u8], decoded: &mut Vec<Decoded>) {
        for byte in bytes {
            match byte {
                b'\n' => {
                    decoded.extend(self.end_line());
                    self.line.clear();
                    self.overlong = false;
                }
                _ if self.line.len() < LONGEST_LINE => self.line.push(*byte),
                _ => self.overlong = true,
            }
        }
    }

    fn end_line(&self) -> Option<Decoded> {
        let garbled = |reason: String| Some(Decoded::Garbled { reason });
        if self.overlong {
            return garbled(format!("a line longer than {LONGEST_LINE} bytes"));
        }
        let Ok(text) = std::str::from_utf8(&self.line) else {
            return garbled("a line that is no text: is the baud rate right?".to_owned());
        };
        // A line cut in its tag still holds commas; a message of the board's does not look like values.
        let Some((tag, values)) = text.trim_end_matches('\r').split_once(':') else {
            let values = text.matches(',').count();
            return if values > 1 {
                garbled(format!("a line without its beginning ({values} commas)"))
            } else {
                None
            };
        };
        if tag.trim() != TAG {
            return if tag.contains(TAG) || values.matches(',').count() > 1 {
                garbled(format!(
                    "a line of values tagged {:?}",
                    tag.trim().chars().take(20).collect::<String>()
                ))
            } else {
                None
            };
        }
        match self.values(values) {
            Ok(volts) => Some(Decoded::Volts(volts)),
            Err(reason) => garbled(reason),
        }
    }

    fn values(&self, text: &str) -> Result<Vec<f32>, String> {
        let text = text.trim();
        let Some(text) = text.strip_suffix(',') else {
            return Err("a line that is cut: no comma at its end".to_owned());
        };
        let volts: Vec<f32> = text
            .split(',')
            .map(|word| {
                word.trim()
                    .parse::<f32>()
                    .ok()
                    .filter(|value| value.is_finite())
                    .ok_or_else(|| {
                        let short: String = word.trim().chars().take(20).collect();
                        format!("{short:?} is no value")
                    })
            })
            .collect::<Result<_, _>>()?;
        if volts.len() == self.channels {
            Ok(volts)
        } else {
            Err(format!(
                "{} values where the pad has {}: is it another pad (--pad)?",
                volts.len(),
                self.channels
            ))
        }
    }
}

/// A frame as the firmware prints it. Values are rounded to four decimals.
#[must_use]
pub fn encode(volts: &[f32]) -> String {
    use std::fmt::Write as _;
    let mut line = format!("{TAG}: ");
    for volt in volts {
        let _ = write!(line, "{volt:13.4},");
    }
    line.push_str("\r\n");
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn fed(chunks: &[&[u8]]) -> Vec<Decoded> {
        let mut decoder = OpenEit::new(3);
        let mut decoded = Vec::new();
        for chunk in chunks {
            decoder.feed(chunk, &mut decoded);
        }
        decoded
    }

    fn reasons(decoded: &[Decoded]) -> Vec<&str> {
        decoded
            .iter()
            .filter_map(|one| match one {
                Decoded::Garbled { reason } => Some(reason.as_str()),
                Decoded::Volts(_) => None,
            })
            .collect()
    }

    #[test]
    fn the_firmwares_line_is_read_in_any_pieces() {
        let line = b"magnitudes:        1.5000,       2.0000,    -300.2500,\r\n";
        let volts = Decoded::Volts(vec![1.5, 2.0, -300.25]);
        assert_eq!(fed(&[line]), std::slice::from_ref(&volts));
        let bytes: Vec<&[u8]> = line.chunks(1).collect();
        assert_eq!(fed(&bytes), std::slice::from_ref(&volts));
        assert_eq!(fed(&[b"magnitudes : 1.5,2,-300.25,\n"]), [volts]);
    }

    #[test]
    fn menus_and_messages_pass_in_silence() {
        assert_eq!(
            fed(&[b"Select mode:\r\n 1) imaging\r\n\r\nstarting\r\n"]),
            []
        );
    }

    #[test]
    fn garbled_lines_are_said_and_the_next_is_read_right() {
        let decoded = fed(&[
            b"magnitudes: 1.0,2.0,\r\n",
            b"magnitudes: 1.0,2.x,3.0,\r\n",
            b"magnitudes: 1.0,2.0,3.\r\n",
            b"des: 1.0,2.0,3.0,\r\n",
            b"1.0,2.0,3.0,\r\n",
            b"magnitudes: \xff\xfe,2.0,3.0,\r\n",
            b"magnitudes: 1.0,2.0,3.0,\r\n",
        ]);
        assert_eq!(
            reasons(&decoded),
            [
                "2 values where the pad has 3: is it another pad (--pad)?",
                "\"2.x\" is no value",
                "a line that is cut: no comma at its end",
                "a line of values tagged \"des\"",
                "a line without its beginning (3 commas)",
                "a line that is no text: is the baud rate right?",
            ]
        );
        assert_eq!(decoded.last(), Some(&Decoded::Volts(vec![1.0, 2.0, 3.0])));
    }

    #[test]
    fn an_endless_line_takes_bounded_memory() {
        let mut decoder = OpenEit::new(3);
        let mut decoded = Vec::new();
        for _ in 0..100 {
            decoder.feed(&[b'7'; 4096], &mut decoded);
        }
        assert!(decoder.line.len() <= LONGEST_LINE);
        decoder.feed(b"\nmagnitudes: 1,2,3,\n", &mut decoded);
        assert_eq!(decoded.len(), 2);
        assert_eq!(decoded[1], Decoded::Volts(vec![1.0, 2.0, 3.0]));
    }

    proptest! {
        #[test]
        fn what_is_encoded_is_decoded(values in proptest::collection::vec(-1e6..1e6f32, 3)) {
            let decoded = fed(&[encode(&values).as_bytes()]);
            let expected: Vec<f32> = values
                .iter()
                .map(|value| format!("{value:.4}").parse().expect("a number"))
                .collect();
            prop_assert_eq!(decoded, vec![Decoded::Volts(expected)]);
        }

        #[test]
        fn random_bytes_never_make_a_frame_of_another_length(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
            for one in fed(&[&bytes, b"\n"]) {
                if let Decoded::Volts(volts) = one {
                    prop_assert_eq!(volts.len(), 3);
                }
            }
        }
    }
}
