//! The reference of a detector: when it is taken, taken again and updated.

use super::Detector;
use super::sign::Judged;
use crate::eit::{FirstFrames, REFERENCE_FRAMES, Reference, quantization_step, saturated_channels};
use crate::types::{Frame, Nanos};

/// A finger that lay on the pad from the start has lifted if, with no touch down, the mean change against a touch's
/// direction exceeds this share ...
const REBOUND_SHARE: f64 = 0.002;
/// ... and this many of its standard deviations.
const REBOUND_DEVIATIONS: f64 = 10.0;
/// So many frames in a row must show it, ...
const REBOUND_FRAMES: usize = 3;
/// ... each no further from the one before than by this much noise ([`Reference::apart`]): a finger that slides away is still there.
const REBOUND_APART: f64 = 1.0;

impl Detector {
    /// Forgets the reference, the touches fitted with it and the palm; lost electrodes stay lost.
    pub(super) fn reset(&mut self) {
        if let Some(locator) = &mut self.locator {
            locator.forget_touches();
        }
        self.reference = Reference::new(self.changes.len());
        self.first_frames = FirstFrames::default();
        self.rebounds.clear();
        self.explained.fill(0.0);
        self.blank_image();
        self.palm_ns = None;
    }

    /// Variance of a reading in units of the weights' variances, and the part of it that is the reference's uncertainty.
    pub(super) fn noise(&self) -> (f64, f64) {
        let (mut count, mut sum, mut steady) = (0usize, 0.0, 0.0);
        for (channel, deviation) in self.sensing.deviations.iter().enumerate() {
            if !deviation.is_finite() || self.reference.is_muted(channel) {
                continue;
            }
            let [noise, doubt] = self.reference.variances(channel);
            let square = deviation * deviation;
            count += 1;
            sum += (noise + doubt) / square;
            steady += doubt / square;
        }
        let count = count.max(1) as f64;
        (sum / count, steady / count)
    }

    /// Updates the reference with the frame, without what the touches explain.
    pub(super) fn follow_reference(&mut self, frame: &Frame) {
        for ((untouched, volt), explained) in self
            .untouched
            .iter_mut()
            .zip(&frame.volts)
            .zip(&self.explained)
        {
            *untouched = volt / (1.0 + explained);
        }
        self.reference.update(&self.untouched, &self.explained);
    }

    /// Whether the mean change over all channels in use is opposite to that of a touch: the reference was taken under a
    /// finger, which has lifted.
    pub(super) fn has_rebounded(&self) -> bool {
        // A press beside a lost electrode can raise the mean of the other channels: its channels count as unchanged.
        let any_lost = self.electrodes.as_ref().is_some_and(|all| all.any_lost());
        let (mut count, mut sum) = (0.0, 0.0);
        for (channel, change) in self.changes.iter().enumerate() {
            if any_lost || !self.reference.is_muted(channel) {
                count += 1.0;
                sum += f64::from(*change);
            }
        }
        // A touch that conducts better lowers the voltages.
        let against = sum / count * f64::from(self.touch_sign().factor());
        let shared = self.reference.shared_noise().of_mean();
        let noise = libm::sqrt(self.reference.change_variance() / count + shared);
        against > REBOUND_SHARE.max(REBOUND_DEVIATIONS * noise)
    }

    /// Whether frames in a row look like a finger that has left the pad after it lay there from the start; the last of
    /// them retakes the reference. A single such frame is only skipped. A frame that shows a lost electrode does not count.
    pub(super) fn is_rebound(&mut self, frame: &Frame) -> bool {
        if self.is_impossible_lift() {
            self.rebounds.clear();
            return false;
        }
        let is_lift = match self.judge_onset(frame) {
            Judged::Touch => false,
            Judged::Lift => true,
            Judged::Unclear => self.tracker.down().is_empty() && self.has_rebounded(),
        };
        if !is_lift {
            self.rebounds.clear();
            return false;
        }
        let last = self.rebounds.last();
        let is_apart = |last: &[f32]| self.reference.apart(last, &frame.volts) > REBOUND_APART;
        if last.is_some_and(|(_, last)| is_apart(last)) {
            self.rebounds.clear();
        }
        self.rebounds.push((frame.t_ns, frame.volts.clone()));
        if self.rebounds.len() >= REBOUND_FRAMES {
            let frames = std::mem::take(&mut self.rebounds);
            self.remember_reference(frame);
            self.retake_reference(&frames);
        }
        true
    }

    /// Takes the reference again, beginning with these frames (time in ns, volts). If they are enough and their noise is the one that is
    /// known, touches are found from the next frame on: one that follows a lift by a tenth of a second must not get into the reference.
    pub(super) fn retake_reference(&mut self, frames: &[(Nanos, Vec<f32>)]) {
        self.references_retaken += 1;
        let is_enough = frames.len() >= REBOUND_FRAMES
            && self.frames.saturating_sub(self.referenced_at) >= REFERENCE_FRAMES as u64
            && !self.noise_is_unknown
            && self.reference.differ_by_noise_only(frames);
        let known = (is_enough && self.reference.is_ready()).then(|| self.reference.clone());
        self.reset();
        if let (Some(mut reference), Some((t_ns, _))) = (known, frames.last()) {
            reference.retake_level(frames);
            self.reference = reference;
            self.explained_ns = *t_ns;
            self.referenced_at = self.frames;
            return;
        }
        for (t_ns, volts) in frames {
            self.take_reference_frame(&Frame {
                t_ns: *t_ns,
                volts: volts.clone(),
            });
        }
    }

    /// Takes gains of the source out of the frame, if they explain all but noise of what the touches before leave of it.
    pub(super) fn take_out_gains(&mut self) {
        if !self.are_gains_distinct {
            return;
        }
        if self.tracker.down().is_empty() {
            self.explained.fill(0.0);
        }
        self.reference
            .take_out_gains(&self.explained, &mut self.changes, !self.is_between);
    }

    /// Adds one of the first frames to the reference. With the last of them, measures the noise of the images and finds
    /// lost electrodes.
    pub(super) fn take_reference_frame(&mut self, frame: &Frame) {
        let Some(first) = self.first_frames.push(frame.t_ns, &frame.volts) else {
            return;
        };
        let first_frames: Vec<Vec<f32>> = first.iter().map(|(_, volts)| volts.clone()).collect();
        self.reference = Reference::new(self.changes.len());
        if self.drives.len() == self.changes.len() {
            self.reference = self.reference.clone().with_drives(self.drives.clone());
        }
        self.reference.set_step(quantization_step(&first_frames));
        for (t_ns, volts) in &first {
            self.reference.add_first_frame(*t_ns, volts);
        }
        self.reference.learn_first_shared_noise(&first);
        self.noise_is_unknown = first_frames.windows(2).all(|pair| pair[0] == pair[1]);
        self.explained_ns = frame.t_ns;
        self.referenced_at = self.frames;
        if self.references_retaken == 0 {
            self.first_ns = frame.t_ns;
        }
        let mut peaks = Vec::with_capacity(first_frames.len());
        for volts in &first_frames {
            self.reference.relative_changes(volts, &mut self.changes);
            self.keep_image_changes();
            self.draw_image();
            peaks.push(self.by_image.peak(&self.image));
        }
        self.by_image.set_noise(peaks);
        self.blank_image();
        self.find_dead_electrodes();
        for channel in saturated_channels(&first_frames, self.reference.is_rounded()) {
            self.reference.mute(channel, true, 0.0);
        }
        if let Some(electrodes) = &mut self.electrodes {
            electrodes.forget_levels_of_lost();
        }
        self.request_for_lost_channels();
        self.request_for_noise();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use crate::eit::Reconstruction;
    use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};
    use crate::touch::Sensing;
    use crate::types::{Method, NANOS_PER_MS, Nanos};

    /// A detector with a reference of 1 V, except for the channels below `dead`, which read zero.
    fn rested(dead: usize) -> Detector {
        let text = shipped_pad(DEFAULT_PAD).expect("shipped").toml;
        let pad = Pad::from_toml("p", text).expect("valid");
        let reconstruction = Reconstruction::from_pad(&pad, Method::Tikhonov).expect("solvable");
        let sensing = Sensing::by_image(Arc::new(reconstruction));
        let mut detector = Detector::for_pad(Arc::new(sensing), &pad.protocol);
        let volts = |c: usize| f32::from(u8::from(c >= dead));
        for frame in 0..REFERENCE_FRAMES as Nanos {
            let frame = Frame {
                t_ns: frame * 10 * NANOS_PER_MS,
                volts: (0..pad.channels()).map(volts).collect(),
            };
            detector.process_frame(&frame, &mut Vec::new());
        }
        assert!(detector.is_ready());
        detector
    }

    #[test]
    fn muted_channels_do_not_hide_a_rebound() {
        let dead = 130;
        let mut detector = rested(dead);
        detector.electrodes = None;
        assert!(!detector.has_rebounded());
        detector.changes[dead..].fill(0.003);
        assert!(detector.has_rebounded());
    }

    #[test]
    fn rezero_resets_palm_wanted_weights_and_lost_electrodes() {
        let mut detector = rested(180);
        assert!(!detector.lost_electrodes().is_empty());
        assert!(detector.wanted().is_some(), "for the channels in use");
        detector.palm_ns = Some([0, 0]);
        detector.rezero(&mut Vec::new());
        assert_eq!(detector.palm_ns, None);
        assert_eq!(detector.wanted(), None);
        assert!(detector.lost_electrodes().is_empty());
        assert!(detector.muted_channels().is_empty());
    }
}
