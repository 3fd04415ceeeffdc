//! What a watcher sends to gelpad.

use super::{BEAT_LINE, READY, RELEASED};

/// What a watcher has sent since the last call.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::platform) struct Answers {
    /// It watches.
    pub(in crate::platform) is_ready: bool,
    /// It has answered a beat.
    pub(in crate::platform) has_answered: bool,
    /// It has released everything.
    pub(in crate::platform) has_released: bool,
    /// It has ended.
    pub(in crate::platform) has_ended: bool,
}

/// Bytes of a watcher, split into lines.
#[derive(Debug, Default)]
pub(in crate::platform) struct AnswerLines {
    /// The beginning of an incomplete line.
    partial: Vec<u8>,
}

impl AnswerLines {
    /// Adds received bytes.
    pub(in crate::platform) fn feed(&mut self, bytes: &[u8], answers: &mut Answers) {
        for byte in bytes {
            if *byte != b'\n' {
                self.partial.push(*byte);
                continue;
            }
            match self.partial.as_slice() {
                line if line == READY.as_bytes() => answers.is_ready = true,
                line if line == RELEASED.as_bytes() => answers.has_released = true,
                line if line == BEAT_LINE.as_bytes() => answers.has_answered = true,
                _ => {}
            }
            self.partial.clear();
        }
    }
}
