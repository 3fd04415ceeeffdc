//! One frame of relative changes to touches: image, contacts with hysteresis, tracking.

use std::sync::Arc;

use super::{Blob, Segmenter, Threshold, Tracker};
use crate::eit::{Imager, Reconstruction, Reference};
use crate::types::{Contact, Frame, Image, Touch};

/// A new touch needs a smoothed peak of this many times the untouched image's: noise at any SNR makes none.
const DOWN_OVER_NOISE: f32 = 2.2;
/// On a pad without noise it needs this relative rise of conductivity: below it is what the model cannot tell.
const LEAST_DOWN: f32 = 0.015;
/// A touch stays down while its peak is above this share of what a new one needs: it does not stutter.
const STAY_SHARE: f32 = 0.7;
/// A weaker peak continues a touch that is down within this distance.
const STAY_WITHIN_MM: f64 = 10.0;
/// Share by which the estimate of the noise moves with each untouched frame.
const NOISE_FOLLOW: f32 = 0.01;

/// Frames to touches. Holds the reference, the matrix and the tracker.
#[derive(Clone, Debug)]
pub struct Detector {
    imager: Imager,
    reference: Reference,
    segmenter: Segmenter,
    tracker: Tracker,
    changes: Vec<f32>,
    image: Image,
    blobs: Vec<Blob>,
    contacts: Vec<Contact>,
    first_frames: Vec<Vec<f32>>,
    /// Mean highest value of an untouched, smoothed image.
    noise_peak: f32,
}

/// What one frame gave.
#[derive(Clone, Copy, Debug)]
pub struct FrameTouches<'a> {
    /// The image; blank while the reference is being taken.
    pub image: &'a Image,
    /// The touches that are down.
    pub down: &'a [Touch],
}

impl Detector {
    /// A detector for a pad's matrix, without a reference yet.
    #[must_use]
    pub fn new(reconstruction: Arc<Reconstruction>) -> Self {
        Self {
            reference: Reference::new(reconstruction.channels()),
            segmenter: Segmenter::new(reconstruction.grid, &reconstruction.coverage),
            tracker: Tracker::default(),
            changes: vec![0.0; reconstruction.channels()],
            image: Image::blank(reconstruction.grid),
            blobs: Vec::new(),
            contacts: Vec::new(),
            first_frames: Vec::new(),
            noise_peak: 0.0,
            imager: Imager::new(reconstruction),
        }
    }

    /// Takes another matrix of the same pad; reference and touches stay.
    ///
    /// # Panics
    /// If the matrix has another number of channels.
    pub fn replace_matrix(&mut self, reconstruction: Arc<Reconstruction>) {
        assert_eq!(reconstruction.channels(), self.changes.len());
        self.segmenter = Segmenter::new(reconstruction.grid, &reconstruction.coverage);
        self.image = Image::blank(reconstruction.grid);
        self.imager = Imager::new(reconstruction);
    }

    /// Takes a frame and appends what became of every touch.
    ///
    /// # Panics
    /// If the frame has another number of voltages than the pad.
    pub fn frame(&mut self, frame: &Frame, changed: &mut Vec<Touch>) {
        if !self.reference.is_ready() {
            self.begin(frame);
            return;
        }
        self.reference.advance(frame.t_ns);
        let noise_peak = self.noise_peak * self.reference.doubt() as f32;
        let down = Threshold(LEAST_DOWN.max(DOWN_OVER_NOISE * noise_peak));
        let stay = Threshold(STAY_SHARE * down.0);
        let highest = self.look(&frame.volts, stay);
        self.contacts.clear();
        for blob in &self.blobs {
            if blob.peak >= down.0 || continues_a_touch(self.tracker.down(), &blob.contact) {
                self.contacts.push(blob.contact);
            }
        }
        self.tracker.follow(frame.t_ns, &self.contacts, changed);
        if highest < stay.0 {
            self.reference.follow(&frame.volts);
            self.noise_peak += NOISE_FOLLOW * (highest - self.noise_peak);
        } else {
            self.reference.hold();
        }
    }

    /// Takes one of the first frames into the reference; with the last of them, learns how high the noise
    /// rises in the images of the untouched pad.
    fn begin(&mut self, frame: &Frame) {
        self.reference.begin(frame.t_ns, &frame.volts);
        self.first_frames.push(frame.volts.clone());
        if !self.reference.is_ready() {
            return;
        }
        let first_frames = std::mem::take(&mut self.first_frames);
        let mut peaks: Vec<f32> = first_frames
            .iter()
            .map(|volts| self.look(volts, Threshold(f32::INFINITY)))
            .collect();
        // The median: a finger that brushes the pad meanwhile must not deafen it.
        peaks.sort_by(f32::total_cmp);
        self.noise_peak = peaks[peaks.len() / 2];
        self.image = Image::blank(self.image.grid);
    }

    /// Makes the image and finds its blobs; returns the highest value of the smoothed image.
    fn look(&mut self, volts: &[f32], threshold: Threshold) -> f32 {
        self.reference.changes(volts, &mut self.changes);
        self.imager.image(
            &self.changes,
            self.reference.change_noise(),
            &mut self.image,
        );
        self.blobs.clear();
        self.segmenter
            .blobs(&self.image, threshold, &mut self.blobs)
    }

    /// Lifts every touch: the source is gone.
    pub fn lift_all(&mut self, changed: &mut Vec<Touch>) {
        self.tracker.lift_all(changed);
    }

    /// The last frame's image and the touches that are down.
    #[must_use]
    pub fn state(&self) -> FrameTouches<'_> {
        FrameTouches {
            image: &self.image,
            down: self.tracker.down(),
        }
    }
}

/// Hysteresis: whether a weak contact lies where a touch is down already.
fn continues_a_touch(down: &[Touch], contact: &Contact) -> bool {
    down.iter().any(|touch| {
        let [dx, dy] = [0, 1].map(|i| touch.contact.centre_mm[i] - contact.centre_mm[i]);
        dx * dx + dy * dy < STAY_WITHIN_MM * STAY_WITHIN_MM
    })
}
