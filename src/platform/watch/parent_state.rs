//! What a watcher knows of the gelpad that it watches: the outputs that may be down.

use super::BEAT_LINE;
use crate::output::HeldOutputs;
use crate::types::Output;

/// What the parent has reported.
#[derive(Debug, Default)]
pub(in crate::platform) struct ParentState {
    /// What may be down. A release because of silence removes nothing: a press may have been on its way.
    pub(in crate::platform) held: HeldOutputs,
    /// The beginning of an incomplete line.
    partial: Vec<u8>,
}

impl ParentState {
    /// Adds received bytes; returns the number of beats in them, which are to be answered.
    pub(in crate::platform) fn feed(&mut self, bytes: &[u8]) -> usize {
        let mut beats = 0;
        for byte in bytes {
            if *byte == b'\n' {
                let text = String::from_utf8_lossy(&self.partial).into_owned();
                self.partial.clear();
                beats += usize::from(text == BEAT_LINE);
                self.take_line(&text);
            } else {
                self.partial.push(*byte);
            }
        }
        beats
    }

    fn take_line(&mut self, line: &str) {
        let Some((word, output)) = line.split_once(' ') else {
            return;
        };
        let Ok(output) = output.parse::<Output>() else {
            return;
        };
        match word {
            "press" => self.held.press(output),
            _ => self.held.release(output),
        }
    }
}
