//! The sensing of play, frame by frame.

use std::sync::Arc;

use crate::touch::{ChannelNoise, Detector, SensingBuilder};
use crate::types::{Frame, NANOS_PER_MS, Nanos, Touch};

/// A hundred frames a second, as in play.
pub(super) const FRAME_NS: Nanos = 10 * NANOS_PER_MS;

/// The detector of play, which gets the weights that it asks for.
pub(super) struct Sensed<'a> {
    pub(super) detector: Detector,
    builder: &'a SensingBuilder,
    /// The noise of its present weights; `None` for the first ones.
    noise: Option<ChannelNoise>,
    changed: Vec<Touch>,
}

impl<'a> Sensed<'a> {
    pub(super) fn new(detector: Detector, builder: &'a SensingBuilder) -> Self {
        Self {
            detector,
            builder,
            noise: None,
            changed: Vec::new(),
        }
    }

    pub(super) fn process(&mut self, frame: &Frame) {
        self.changed.clear();
        self.detector.process_frame(frame, &mut self.changed);
        if let Some(wanted) = self.detector.wanted() {
            self.noise = Some(wanted.clone());
            self.rebuild();
        }
    }

    /// Channels that the detector leaves out, as those of a lost electrode.
    pub(super) fn left_out(&self) -> Vec<usize> {
        let sensing = self.detector.sensing();
        let channels = 0..sensing.channels();
        channels.filter(|c| !sensing.uses_channel(*c)).collect()
    }

    /// Locates touches on another pad from now on.
    pub(super) fn change_pad(&mut self, builder: &'a SensingBuilder) {
        self.builder = builder;
        self.rebuild();
    }

    /// As in play: where no weights can be made, the present ones stay.
    fn rebuild(&mut self) {
        let built = match &self.noise {
            Some(noise) => self.builder.build(noise),
            None => self.builder.build_initial(),
        };
        if let Ok(sensing) = built {
            self.detector.set_sensing(Arc::new(sensing));
        }
    }
}
