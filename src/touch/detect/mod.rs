//! One frame to touches: reference, image, contacts, tracking; and what to do when a frame cannot be right.
//!
//! Where the pad's table of responses is at hand, contacts are located in the voltages and the image is for the eye; a
//! palm or a forearm, which is no finger, is taken from the image. Without a table (a pad that is too large to be solved),
//! contacts come from the image.
//!
//! Invariant: no touch begins in a frame that no touches can explain. Touches that are down wait for the next frame that can be
//! explained, though not for long.

mod palm;
mod weights;

use std::sync::Arc;

use super::{Correction, Locator, Sensing, Tracker};
use crate::eit::{Faults, Imager, Reconstruction, Reference, Verdict};
use crate::pad::Protocol;
use crate::touch::by_image::ByImage;
use crate::types::{Frame, Image, NANOS_PER_MS, Nanos, Touch};

/// A jump of the mean change against a touch's direction by more than this share, and by more than this many of its
/// deviations, while nothing is touched: a finger that lay on the pad from the start has left it.
const REBOUND: (f64, f64) = (0.002, 10.0);
/// A frame is no frame of a touched pad if what no touch explains exceeds what noise and the model's error explain by this
/// factor.
const UNEXPLAINED: f64 = 9.0;
/// Nor is it if this is half-way so, and the touches that were found leave this many times of what they may: not even a palm
/// does.
const SUSPICIOUS: f64 = 3.0;
const UNEXPLAINED_REST: f64 = 60.0;
/// A touch never changes so many readings by this share and more, beyond their noise by so many deviations: a reading that is
/// gone is.
const BEYOND_TOUCH: (usize, f64) = (4, 0.85);
const BEYOND_DEVIATIONS: f64 = 6.0;
/// Touches that are down wait this long for a frame that can be explained.
const WAIT_NS: Nanos = 500 * NANOS_PER_MS;
/// Frames to touches. Holds the reference, the matrix and the tracker.
#[derive(Clone, Debug)]
pub struct Detector {
    sensing: Arc<Sensing>,
    imager: Imager,
    locator: Option<Locator>,
    by_image: ByImage,
    correction: Option<Correction>,
    reference: Reference,
    faults: Option<Faults>,
    tracker: Tracker,
    changes: Vec<f32>,
    /// What the touches change in each channel, relative.
    explained: Vec<f32>,
    /// The frame less its touches, in the instrument's units.
    untouched: Vec<f32>,
    image: Image,
    contacts: Vec<crate::types::Contact>,
    first_frames: Vec<Vec<f32>>,
    /// Since when a palm lies on the pad, and when it was last seen.
    palm_ns: Option<[Nanos; 2]>,
    /// The last frame that was explained.
    explained_ns: Nanos,
    frames: u64,
    /// Weights for which a new matrix is wanted.
    wanted: Option<Vec<f64>>,
    /// How often the reference was taken anew.
    retaken: u64,
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
    /// A detector that finds touches in images alone, without a reference yet.
    #[must_use]
    pub fn new(reconstruction: Arc<Reconstruction>) -> Self {
        Self::with(Arc::new(Sensing::by_image(reconstruction)), None)
    }

    /// A detector for all that a pad's frames hold, without a reference yet.
    #[must_use]
    pub fn of_pad(sensing: Arc<Sensing>, protocol: &Protocol) -> Self {
        Self::with(sensing, Some(Faults::new(protocol)))
    }

    fn with(sensing: Arc<Sensing>, faults: Option<Faults>) -> Self {
        let channels = sensing.channels();
        let reconstruction = &sensing.reconstruction;
        Self {
            imager: Imager::new(Arc::clone(reconstruction)),
            locator: sensing.locating.as_deref().map(Locator::new),
            by_image: ByImage::new(reconstruction),
            correction: None,
            reference: Reference::new(channels),
            faults,
            tracker: Tracker::default(),
            changes: vec![0.0; channels],
            explained: vec![0.0; channels],
            untouched: vec![0.0; channels],
            image: Image::blank(reconstruction.grid),
            contacts: Vec::new(),
            first_frames: Vec::new(),
            palm_ns: None,
            explained_ns: 0,
            frames: 0,
            wanted: None,
            retaken: 0,
            sensing,
        }
    }

    /// Moves located contacts to where presses at known places have shown them to be.
    #[must_use]
    pub fn corrected(mut self, correction: Option<Correction>) -> Self {
        self.correction = correction;
        self
    }

    /// Takes another matrix and other weights of the same pad; reference and touches stay.
    ///
    /// # Panics
    /// If they are for another number of channels.
    pub fn take(&mut self, sensing: Arc<Sensing>) {
        assert_eq!(sensing.channels(), self.changes.len());
        let reconstruction = &sensing.reconstruction;
        self.image = Image::blank(reconstruction.grid);
        self.by_image.take(reconstruction);
        self.imager = Imager::new(Arc::clone(reconstruction));
        match (&mut self.locator, sensing.locating.as_deref()) {
            (Some(locator), Some(locating)) => locator.take(locating),
            (locator, locating) => *locator = locating.map(Locator::new),
        }
        self.sensing = sensing;
        self.wanted = None;
        self.want_if_lost();
    }

    /// The weights for which another matrix is wanted, if one is: relative deviations of the channels, infinite for one to
    /// leave out.
    #[must_use]
    pub fn wanted(&self) -> Option<&[f64]> {
        self.wanted.as_deref()
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
        self.frames += 1;
        self.reference.advance(frame.t_ns);
        self.reference.changes(&frame.volts, &mut self.changes);
        if self.tracker.down().is_empty() && self.has_rebounded() {
            self.retaken += 1;
            self.start_anew(frame);
            return;
        }
        match self.locator.take() {
            Some(mut locator) => {
                self.locate(&mut locator, frame, changed);
                self.locator = Some(locator);
                self.weigh_now_and_then();
            }
            None => self.find_in_image(frame, changed),
        }
    }

    /// Forgets the reference: the pad counts as untouched as it is in the next frames. Touches that are down go up.
    pub fn rezero(&mut self, changed: &mut Vec<Touch>) {
        self.tracker.lift_all(changed);
        if let Some(locator) = &mut self.locator {
            locator.forget();
        }
        self.reference = Reference::new(self.changes.len());
        self.first_frames.clear();
        self.image = Image::blank(self.image.grid);
    }

    /// Touches by the voltages.
    fn locate(&mut self, locator: &mut Locator, frame: &Frame, changed: &mut Vec<Touch>) {
        let (noise, steady) = self.noise();
        let seen = locator.take_frame(&self.changes, noise);
        let is_late = frame.t_ns.saturating_sub(self.explained_ns) > WAIT_NS;
        // While other weights are awaited, the present ones explain nothing rightly; but they will not be awaited for ever.
        let waits_for_weights = !is_late
            && self.wanted.as_ref().is_some_and(|wanted| {
                (0..wanted.len()).any(|c| wanted[c].is_finite() != self.sensing.counts(c))
            });
        if seen.outside > UNEXPLAINED || waits_for_weights || self.is_beyond_touch() {
            self.let_pass(locator, frame, changed);
            return;
        }
        let found = locator.locate(noise, steady);
        if found.rest > UNEXPLAINED_REST && seen.outside > SUSPICIOUS {
            locator.go_back();
            self.let_pass(locator, frame, changed);
            return;
        }
        self.explained_ns = frame.t_ns;
        locator.explain(&mut self.explained);
        self.contacts.clear();
        self.contacts.extend(locator.contacts());
        if let Some(correction) = &mut self.correction {
            correction.apply(&self.changes, &mut self.contacts);
        }
        self.make_image();
        if self.is_under_palm(found.rest, frame.t_ns) {
            self.bear_palm(frame, changed);
            return;
        }
        let were_down = self.tracker.down().len();
        self.tracker.follow(frame.t_ns, &self.contacts, changed);
        if self.tracker.down().len() < were_down {
            // The gel springs back.
            self.reference.hold();
        }
        if let Some(faults) = &mut self.faults {
            faults.explained();
        }
        self.watch_lost(frame);
        self.follow_reference(frame);
    }

    /// Whether some readings have changed as no touch changes them.
    fn is_beyond_touch(&self) -> bool {
        let (least, beyond) = BEYOND_TOUCH;
        let wild = (0..self.changes.len()).filter(|channel| {
            let [noise, doubt] = self.reference.variances(*channel);
            let change = f64::from(self.changes[*channel].abs());
            change.is_nan() || change > beyond + BEYOND_DEVIATIONS * libm::sqrt(noise + doubt)
        });
        wild.count() >= least
    }

    /// Lets a frame pass that no touches explain: no touch begins; those that are down wait, for a while.
    fn let_pass(&mut self, locator: &mut Locator, frame: &Frame, changed: &mut Vec<Touch>) {
        self.blame(frame);
        self.make_image();
        if frame.t_ns.saturating_sub(self.explained_ns) > WAIT_NS {
            self.tracker.lift_all(changed);
            locator.forget();
            self.explained.fill(0.0);
            return;
        }
        self.contacts.clear();
        let down = self.tracker.down().iter().map(|touch| touch.contact);
        self.contacts.extend(down);
        self.tracker.follow(frame.t_ns, &self.contacts, changed);
    }

    /// Touches by the image.
    fn find_in_image(&mut self, frame: &Frame, changed: &mut Vec<Touch>) {
        self.make_image();
        let doubt = self.reference.doubt();
        let down = self.tracker.down();
        let is_quiet = self
            .by_image
            .contacts(&self.image, doubt, down, &mut self.contacts);
        self.tracker.follow(frame.t_ns, &self.contacts, changed);
        if self.tracker.down().is_empty() && is_quiet {
            self.reference.follow(&frame.volts, &self.explained);
        } else {
            self.reference.hold();
        }
    }

    /// Variance of a reading, in units of the weights', and the part of it that is the reference's doubt.
    fn noise(&self) -> (f64, f64) {
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

    /// Follows the reference where the touches leave it alone.
    fn follow_reference(&mut self, frame: &Frame) {
        for ((untouched, volt), explained) in self
            .untouched
            .iter_mut()
            .zip(&frame.volts)
            .zip(&self.explained)
        {
            *untouched = volt / (1.0 + explained);
        }
        self.reference.follow(&self.untouched, &self.explained);
    }

    /// Whether the pad suddenly reads as if it were touched less than not at all: the reference was taken under a finger
    /// that has lifted.
    fn has_rebounded(&self) -> bool {
        let count = self.changes.len() as f64;
        let mean = self
            .changes
            .iter()
            .map(|change| f64::from(*change))
            .sum::<f64>()
            / count;
        // Where a touch conducts better, it lowers the voltages.
        let against = mean * f64::from(self.imager.reconstruction().touch_factor());
        against
            > REBOUND
                .0
                .max(REBOUND.1 * self.reference.change_noise() / libm::sqrt(count))
    }

    /// Takes the reference anew, beginning with this frame.
    fn start_anew(&mut self, frame: &Frame) {
        if let Some(locator) = &mut self.locator {
            locator.forget();
        }
        self.palm_ns = None;
        self.reference = Reference::new(frame.volts.len());
        self.image = Image::blank(self.image.grid);
        self.begin(frame);
    }

    /// Takes one of the first frames into the reference; with the last of them, learns how high the noise
    /// rises in the images of the untouched pad.
    fn begin(&mut self, frame: &Frame) {
        self.reference.begin(frame.t_ns, &frame.volts);
        self.first_frames.push(frame.volts.clone());
        if !self.reference.is_ready() {
            return;
        }
        self.explained_ns = frame.t_ns;
        self.explained.fill(0.0);
        let first_frames = std::mem::take(&mut self.first_frames);
        let mut peaks = Vec::with_capacity(first_frames.len());
        for volts in &first_frames {
            self.reference.changes(volts, &mut self.changes);
            self.make_image();
            peaks.push(self.by_image.highest(&self.image));
        }
        self.by_image.learn(peaks);
        self.image = Image::blank(self.image.grid);
        if let Some(faults) = &mut self.faults {
            let reference = &self.reference;
            for verdict in faults.begin(|channel| reference.is_muted(channel)) {
                if let Verdict::Lost(electrode) = verdict {
                    for channel in faults.channels(electrode) {
                        self.reference.mute(*channel, true, 0.0);
                    }
                }
            }
        }
        self.want_if_lost();
        self.want_if_noisier();
    }

    /// Makes the image of the changes; where a channel is left out, the touches say what it would read.
    fn make_image(&mut self) {
        for channel in 0..self.changes.len() {
            if self.reference.is_muted(channel) {
                self.changes[channel] = self.explained[channel];
            }
            self.changes[channel] *= self.sensing.image_weights[channel];
        }
        self.imager.image(
            &self.changes,
            self.reference.change_noise(),
            &mut self.image,
        );
    }

    /// Channels that are left out: dead or loose.
    #[must_use]
    pub fn muted_channels(&self) -> Vec<usize> {
        self.reference.muted_channels()
    }

    /// Electrodes that are left out, ascending, counted from 0.
    #[must_use]
    pub fn lost_electrodes(&self) -> Vec<usize> {
        self.faults.as_ref().map(Faults::lost).unwrap_or_default()
    }

    /// How often the reference was taken anew, because a finger had lain on the pad while it was taken.
    #[must_use]
    pub fn retaken(&self) -> u64 {
        self.retaken
    }

    /// Whether the reference is there: from then on changes mean something.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.reference.is_ready()
    }

    /// The last frame's relative change in each channel, and how much of it its touches explain.
    #[must_use]
    pub fn changes(&self) -> (&[f32], &[f32]) {
        (&self.changes, &self.explained)
    }

    /// What each channel reads of the untouched pad, and the relative deviation of a reading; infinite where it is left out.
    #[must_use]
    pub fn at_rest(&self) -> [Vec<f32>; 2] {
        let single = |values: &[f64]| values.iter().map(|value| *value as f32).collect();
        [
            single(self.reference.volts()),
            single(&self.reference.deviations()),
        ]
    }

    /// Lifts every touch: the source is gone.
    pub fn lift_all(&mut self, changed: &mut Vec<Touch>) {
        self.tracker.lift_all(changed);
        if let Some(locator) = &mut self.locator {
            locator.forget();
        }
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
