//! Numbers of a line that has not ended yet, for boards that take long to send one.
//!
//! A line is the proof of its numbers: only when it ends is it known how they are separated, how many there are, and that none was
//! cut. So the numbers of a line are handed up while it arrives only if reading the line before in the same way gave exactly its
//! values. A word that is not a number ends that for the rest of its line.
//!
//! Invariant: what is handed up of a line are its first values, in order and once.

use super::{Decoded, MOST_VALUES, Readings};

/// Reads the words of an incomplete line.
#[derive(Clone, Debug, Default)]
pub(super) struct EarlyWords {
    is_on: bool,
    /// Whether the last complete line was read rightly.
    is_proved: bool,
    /// Where the first word starts that has not been read, bytes from the start of the line.
    next: usize,
    values: Vec<f32>,
    /// Values that were handed up.
    handed_up: usize,
    /// A word of the line is not a number.
    is_odd: bool,
}

/// How the words of a line are read.
pub(super) struct WordRule<'a> {
    /// Whether a byte separates words.
    pub(super) is_separator: &'a dyn Fn(u8) -> bool,
    /// Whether several separators in a row are one.
    pub(super) may_repeat: bool,
    /// The number of the word with this index; none if it is not a number.
    pub(super) parse: &'a dyn Fn(usize, &str) -> Option<f32>,
}

impl EarlyWords {
    /// From now on numbers are handed up.
    pub(super) fn switch_on(&mut self) {
        self.is_on = true;
    }

    /// Reads the words of the incomplete line so far and hands up their values. A word ends with a separator.
    pub(super) fn read(&mut self, line: &[u8], rule: &WordRule<'_>, decoded: &mut Vec<Decoded>) {
        if !self.is_on || self.is_odd {
            return;
        }
        while let Some(length) = line[self.next..]
            .iter()
            .position(|byte| (rule.is_separator)(*byte))
        {
            let word = &line[self.next..self.next + length];
            self.next += length + 1;
            if word.is_empty() && rule.may_repeat {
                continue;
            }
            let text = std::str::from_utf8(word).ok();
            let value = text.and_then(|text| (rule.parse)(self.values.len(), text));
            match value {
                Some(value) if self.values.len() < MOST_VALUES => self.values.push(value),
                _ => {
                    self.is_odd = true;
                    return;
                }
            }
        }
        if self.is_proved && self.values.len() > self.handed_up {
            decoded.push(Decoded::Readings(Readings::from_values(
                self.handed_up,
                self.values[self.handed_up..].to_vec(),
            )));
            self.handed_up = self.values.len();
        }
    }

    /// The line has ended, with these values; none if it is garbled or no frame.
    pub(super) fn end_line(&mut self, values: Option<&[f32]>) {
        if let Some(values) = values.filter(|_| !self.values.is_empty()) {
            self.is_proved = !self.is_odd && values.starts_with(&self.values);
        }
        self.clear();
    }

    /// Forgets the incomplete line.
    pub(super) fn clear(&mut self) {
        self.next = 0;
        self.values.clear();
        self.handed_up = 0;
        self.is_odd = false;
    }

    /// Bytes held.
    pub(super) fn held_bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }
}
