//! A frame that arrives in packets, each with some of its values.
//!
//! Invariant: a frame is complete only if each of its values arrived once, in order, in packets with its number.

use super::{Stamp, WireFrame};

/// A packet with some values of a frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PartPacket {
    /// The place of the first value in the frame.
    pub(super) first: usize,
    /// Number of values of the frame.
    pub(super) total: usize,
    pub(super) values: Vec<f32>,
    /// Number of the frame.
    pub(super) sequence: u32,
    /// When the values were taken.
    pub(super) stamp: Stamp,
}

/// What a packet does to its frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct AddedPart {
    /// Whether it continues its frame.
    pub(super) is_next: bool,
    /// What is wrong, for people.
    pub(super) problem: Option<String>,
    /// The frame, if it is complete.
    pub(super) frame: Option<WireFrame>,
}

/// The frame under way.
#[derive(Clone, Debug, Default)]
pub(super) struct PartialFrame {
    sequence: u32,
    total: usize,
    values: Vec<f32>,
    /// A frame that cannot become complete: its other parts are not reported again.
    given_up: Option<u32>,
}

impl PartialFrame {
    /// Adds a packet.
    pub(super) fn add(&mut self, part: PartPacket) -> AddedPart {
        let mut added = AddedPart::default();
        let is_same = !self.values.is_empty() && part.sequence == self.sequence;
        if is_same
            && part.total == self.total
            && part.first + part.values.len() <= self.values.len()
        {
            added.problem = Some(format!(
                "values {} to {} of frame {} again",
                part.first,
                part.first + part.values.len() - 1,
                part.sequence
            ));
            return added;
        }
        let continues = is_same && part.total == self.total && part.first == self.values.len();
        if !continues {
            if !self.values.is_empty() {
                added.problem = Some(format!(
                    "frame {} ended after {} of {} values",
                    self.sequence,
                    self.values.len(),
                    self.total
                ));
                self.given_up = Some(self.sequence);
            }
            self.values.clear();
            if part.first > 0 {
                if self.given_up != Some(part.sequence) {
                    self.given_up = Some(part.sequence);
                    added.problem = Some(format!(
                        "frame {} without its values before {}",
                        part.sequence, part.first
                    ));
                }
                return added;
            }
            self.sequence = part.sequence;
            self.total = part.total;
        }
        added.is_next = true;
        self.values.extend_from_slice(&part.values);
        if self.values.len() == self.total {
            added.frame = Some(WireFrame {
                values: std::mem::take(&mut self.values),
                sequence: Some(part.sequence),
                stamp: Some(part.stamp),
                listing: None,
            });
        }
        added
    }

    /// Bytes held.
    pub(super) fn held_bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(sequence: u32, first: usize, count: usize) -> PartPacket {
        PartPacket {
            first,
            total: 8,
            values: (first..first + count).map(|value| value as f32).collect(),
            sequence,
            stamp: Stamp {
                ticks: 10 * sequence + first as u32,
                tick_ns: 1000,
            },
        }
    }

    /// The numbers of the complete frames, and the problems.
    fn add_all(parts: &[PartPacket]) -> (Vec<u32>, Vec<String>) {
        let mut frame = PartialFrame::default();
        let (mut whole, mut problems) = (Vec::new(), Vec::new());
        for part in parts {
            let added = frame.add(part.clone());
            problems.extend(added.problem);
            if let Some(frame) = added.frame {
                assert_eq!(frame.values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
                whole.extend(frame.sequence);
            }
        }
        (whole, problems)
    }

    #[test]
    fn a_frame_is_complete_with_its_last_part_and_has_its_time() {
        let mut frame = PartialFrame::default();
        assert_eq!(frame.add(part(3, 0, 5)).frame, None);
        let whole = frame.add(part(3, 5, 3)).frame.expect("complete");
        assert_eq!(whole.stamp, Some(part(3, 5, 3).stamp));
    }

    #[test]
    fn lost_repeated_and_shuffled_parts_cost_their_frame_and_are_reported_once() {
        // A part of frame 2 is lost.
        let (whole, problems) = add_all(&[
            part(1, 0, 4),
            part(1, 4, 4),
            part(2, 0, 2),
            part(2, 4, 2),
            part(2, 6, 2),
            part(3, 0, 8),
        ]);
        assert_eq!(whole, [1, 3]);
        assert_eq!(problems, ["frame 2 ended after 2 of 8 values"]);
        // A part comes twice.
        let (whole, problems) = add_all(&[part(1, 0, 4), part(1, 0, 4), part(1, 4, 4)]);
        assert_eq!(whole, [1]);
        assert_eq!(problems, ["values 0 to 3 of frame 1 again"]);
        // Two parts are exchanged.
        let (whole, problems) = add_all(&[part(1, 4, 4), part(1, 0, 4), part(2, 0, 8)]);
        assert_eq!(whole, [2]);
        assert_eq!(
            problems,
            [
                "frame 1 without its values before 4",
                "frame 1 ended after 4 of 8 values"
            ]
        );
    }
}
