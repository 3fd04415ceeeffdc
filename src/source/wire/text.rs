//! Lines of text from bytes, for all text formats.

use super::early::{EarlyWords, WordRule};
use super::{Decoded, MOST_VALUES, WireFrame};

/// A longer line is noise at the wrong baud rate: the values of the largest frame take 14 bytes each.
const LONGEST_LINE: usize = 64 * 1024;

/// Why a line is not text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InvalidLine {
    Overlong,
    NotUtf8,
}

impl InvalidLine {
    pub(super) fn reason(self) -> &'static str {
        match self {
            Self::Overlong => "a line without an end: is the baud rate right?",
            Self::NotUtf8 => "a line that is not text: is the baud rate right?",
        }
    }
}

/// The incomplete line.
#[derive(Clone, Debug, Default)]
pub(super) struct LineBuffer {
    line: Vec<u8>,
    overlong: bool,
}

impl LineBuffer {
    /// Takes bytes and calls `take` for every complete line, with its text without the line end and its bytes.
    pub(super) fn feed(
        &mut self,
        bytes: &[u8],
        mut take: impl FnMut(Result<&str, InvalidLine>, &[u8]),
    ) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            let (body, ends) = match piece.split_last() {
                Some((b'\n', body)) => (body, true),
                _ => (piece, false),
            };
            let room = LONGEST_LINE - self.line.len();
            self.overlong |= body.len() > room;
            self.line.extend_from_slice(&body[..body.len().min(room)]);
            if ends {
                let text = match std::str::from_utf8(&self.line) {
                    _ if self.overlong => Err(InvalidLine::Overlong),
                    Ok(text) => Ok(text.trim_end_matches('\r')),
                    Err(_) => Err(InvalidLine::NotUtf8),
                };
                take(text, &self.line);
                self.clear();
            }
        }
    }

    /// Decodes every complete line with `parse`, which returns none for lines that are to be ignored, and hands up numbers of
    /// the incomplete one.
    pub(super) fn decode(
        &mut self,
        bytes: &[u8],
        decoded: &mut Vec<Decoded>,
        parse: impl Fn(&str) -> Option<Result<Vec<f32>, String>>,
        early: (&mut EarlyWords, &WordRule<'_>),
    ) {
        let (words, rule) = early;
        self.feed(bytes, |line, raw| {
            let parsed = match line {
                Ok(text) => parse(text),
                Err(invalid) => Some(Err(invalid.reason().to_owned())),
            };
            words.end_line(match &parsed {
                Some(Ok(values)) => Some(values),
                _ => None,
            });
            decoded.extend(parsed.map(|parsed| match parsed {
                Ok(values) => Decoded::Frame(WireFrame::from_values(values)),
                Err(reason) => Decoded::garbled(reason, raw),
            }));
        });
        words.read(&self.line, rule, decoded);
    }

    pub(super) fn clear(&mut self) {
        self.line.clear();
        self.overlong = false;
    }

    pub(super) fn held_bytes(&self) -> usize {
        self.line.len()
    }
}

/// A finite number, or an error that quotes the word.
pub(super) fn number(word: &str) -> Result<f32, String> {
    let word = word.trim();
    // The parser accepts `inf`, `nan` and the like, but no board measures them.
    word.parse::<f32>()
        .ok()
        .filter(|value| value.is_finite() && !word.contains(['n', 'N', 'f', 'F']))
        .ok_or_else(|| {
            let short: String = word.chars().take(20).collect();
            format!("{short:?} is not a number")
        })
}

/// The numbers of words; an error if there are too many for a frame.
pub(super) fn numbers<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vec<f32>, String> {
    let values: Vec<f32> = words
        .take(MOST_VALUES + 1)
        .map(number)
        .collect::<Result<_, _>>()?;
    if values.len() > MOST_VALUES {
        return Err(format!("more than {MOST_VALUES} values"));
    }
    Ok(values)
}

/// Number of decimals. Firmware prints all values with the same number: if they differ, digits were lost.
pub(super) fn decimals(word: &str) -> usize {
    word.trim()
        .split_once('.')
        .map_or(0, |(_, decimals)| decimals.len())
}

/// An error if words have different numbers of decimals.
pub(super) fn same_decimals<'a>(mut words: impl Iterator<Item = &'a str>) -> Result<(), String> {
    let Some(first) = words.next().map(decimals) else {
        return Ok(());
    };
    match words.map(decimals).find(|count| *count != first) {
        Some(other) => Err(format!(
            "values with {first} and with {other} decimals: digits were lost"
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_may_arrive_in_any_pieces() {
        let bytes = b"one\r\ntwo\n\xff\n\nlast";
        for size in 1..bytes.len() {
            let mut buffer = LineBuffer::default();
            let mut lines = Vec::new();
            for piece in bytes.chunks(size) {
                buffer.feed(piece, |line, _| lines.push(line.map(str::to_owned)));
            }
            let whole = |text: &str| Ok(text.to_owned());
            assert_eq!(
                lines,
                [
                    whole("one"),
                    whole("two"),
                    Err(InvalidLine::NotUtf8),
                    whole("")
                ]
            );
            assert_eq!(buffer.held_bytes(), 4);
        }
    }

    #[test]
    fn an_endless_line_takes_bounded_memory() {
        let mut buffer = LineBuffer::default();
        for _ in 0..100 {
            buffer.feed(&[b'7'; 4096], |_, _| panic!("no line ends"));
        }
        assert!(buffer.held_bytes() <= LONGEST_LINE);
        let mut lines = Vec::new();
        buffer.feed(b"\n8\n", |line, _| lines.push(line.map(str::to_owned)));
        assert_eq!(lines, [Err(InvalidLine::Overlong), Ok("8".to_owned())]);
    }

    #[test]
    fn special_numbers_are_refused() {
        for word in ["inf", "NaN", "infinity", "1.2.3", "", "0x10", "1e99"] {
            assert!(number(word).is_err(), "{word}");
        }
        assert_eq!(number(" -1.5e-3 "), Ok(-1.5e-3));
    }
}
