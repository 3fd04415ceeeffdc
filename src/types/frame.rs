//! One frame of voltages.

use super::Nanos;

/// The measured voltages of one frame, as `f32` from decoder to recording: boards send no more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time stamp of the device.
    pub t_ns: Nanos,
    /// One voltage per channel, in the pad's measurement order, in any unit: only relative changes are used.
    pub volts: Vec<f32>,
}

/// Some readings of a frame that were taken at one moment: those of a drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// When they were taken.
    pub t_ns: Nanos,
    /// The channel of the first of them. The part that holds the pad's last channel ends a frame.
    pub first: usize,
    /// Consecutive readings, in the pad's measurement order.
    pub volts: Vec<f32>,
}

/// Assembles frames from their parts.
#[derive(Clone, Debug, Default)]
pub struct FrameAssembler {
    volts: Vec<f32>,
}

impl FrameAssembler {
    /// Takes a part and returns the frame of `channels` voltages that it completes. A frame without some of its parts is left out.
    pub fn add(&mut self, part: &Part, channels: usize) -> Option<Frame> {
        if part.first == 0 {
            self.volts.clear();
        }
        if part.first != self.volts.len() {
            self.volts.clear();
            return None;
        }
        self.volts.extend_from_slice(&part.volts);
        (self.volts.len() == channels).then(|| Frame {
            t_ns: part.t_ns,
            volts: std::mem::take(&mut self.volts),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_with_all_parts_are_assembled() {
        let mut assembler = FrameAssembler::default();
        let mut add = |t_ns, first, volts: &[f32]| {
            let volts = volts.to_vec();
            assembler.add(&Part { t_ns, first, volts }, 3)
        };
        assert_eq!(add(1, 1, &[2.0]), None, "the start is missing");
        assert_eq!(add(2, 0, &[1.0]), None);
        assert_eq!(add(3, 2, &[3.0]), None, "the middle is missing");
        assert_eq!(add(4, 0, &[1.0]), None);
        assert_eq!(add(5, 1, &[2.0]), None);
        let frame = add(6, 2, &[3.0]).expect("complete");
        assert_eq!((frame.t_ns, frame.volts), (6, vec![1.0, 2.0, 3.0]));
    }
}
