//! Frames as their drives were read, one after another, over the frame period that ends at the frame's time.

use crate::pad::Protocol;
use crate::types::{Frame, Nanos, Part};

/// Splits frames into the parts of their drives.
#[derive(Clone, Debug)]
pub struct PartSplitter {
    /// First channel of each run of channels of one drive, and the number of channels.
    bounds: Vec<usize>,
    /// The frame whose period is not known yet: the first one has that of the second.
    first: Option<Frame>,
    last_ns: Option<Nanos>,
}

impl PartSplitter {
    /// For the frames of a protocol.
    #[must_use]
    pub fn new(protocol: &Protocol) -> Self {
        Self {
            bounds: protocol.drive_bounds(),
            first: None,
            last_ns: None,
        }
    }

    /// Takes a frame and returns the parts that are known, in the order in which they were read: none of the first frame, then
    /// those of the first two.
    pub fn take(&mut self, frame: Frame) -> Vec<Part> {
        let Some(before_ns) = self.last_ns else {
            self.last_ns = Some(frame.t_ns);
            self.first = Some(frame);
            return Vec::new();
        };
        self.last_ns = Some(frame.t_ns);
        let period_ns = frame.t_ns - before_ns.min(frame.t_ns);
        let mut parts = Vec::new();
        if let Some(first) = self.first.take() {
            self.split(&first, period_ns.min(first.t_ns), &mut parts);
        }
        self.split(&frame, period_ns, &mut parts);
        parts
    }

    /// The parts of a single frame, if there was no other.
    pub fn finish(&mut self) -> Vec<Part> {
        let mut parts = Vec::new();
        if let Some(first) = self.first.take() {
            self.split(&first, 0, &mut parts);
        }
        parts
    }

    fn split(&self, frame: &Frame, period_ns: Nanos, parts: &mut Vec<Part>) {
        let count = self.bounds.len() as Nanos - 1;
        parts.extend(self.bounds.windows(2).zip(1..).map(|(span, read)| Part {
            // The last part is read at the frame's time.
            t_ns: frame.t_ns - period_ns * (count - read) / count,
            first: span[0],
            volts: frame.volts[span[0]..span[1]].to_vec(),
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_read_over_the_period_that_ends_at_its_time() {
        let pairs = Protocol::pairs_with_step(4, 1);
        let protocol = Protocol::from_patterns(4, &pairs, &pairs, false).expect("valid");
        let channels = protocol.channels.len();
        let frame = |t_ns| Frame {
            t_ns,
            volts: (0..channels).map(|c| c as f32).collect(),
        };
        let mut splitter = PartSplitter::new(&protocol);
        assert!(
            splitter.take(frame(1000)).is_empty(),
            "its period is not known"
        );
        let parts = splitter.take(frame(1400));
        let times: Vec<Nanos> = parts.iter().map(|part| part.t_ns).collect();
        assert_eq!(times, [700, 800, 900, 1000, 1100, 1200, 1300, 1400]);
        let volts: Vec<f32> = parts[..4]
            .iter()
            .flat_map(|part| part.volts.clone())
            .collect();
        assert_eq!(volts, frame(0).volts);
        assert!(parts.iter().all(|part| part.volts[0] == part.first as f32));
        assert!(splitter.finish().is_empty());
    }
}
