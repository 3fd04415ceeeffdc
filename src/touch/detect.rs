//! One frame of relative changes to touches: image, contacts with hysteresis, tracking.

use std::sync::Arc;

use super::{Blob, Segmenter, Threshold, Tracker};
use crate::eit::{Imager, Reconstruction, Reference};
use crate::types::{Contact, Frame, Image, Touch};

/// A new touch needs a smoothed peak of this many times the untouched image's: noise at any SNR makes none.
const DOWN_OVER_NOISE: f32 = 2.2;
/// On a pad without noise it needs this relative rise of conductivity: below it is what the model cannot tell.
const LEAST_DOWN: f32 = 0.015;
/// A touch stays down while its peak is above this share of what a new one needs: it does not stutter. The reference's
/// doubt, which grows while a press is held, raises what a new one needs but never lifts one that is down.
const STAY_SHARE: f32 = 0.7;
/// Doubt counts up to this factor.
const MOST_DOUBT: f32 = 3.0;
/// A weaker peak continues a touch that is down within this distance.
const STAY_WITHIN_MM: f64 = 10.0;
/// A jump of the mean change against a touch's direction by more than this share, and by more than this many of its
/// deviations, while nothing is touched: a finger that lay on the pad from the start has left it.
const REBOUND: (f64, f64) = (0.002, 10.0);
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
            retaken: 0,
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
        let sure = LEAST_DOWN.max(DOWN_OVER_NOISE * self.noise_peak);
        let doubt = (self.reference.doubt() as f32).min(MOST_DOUBT);
        let stay = Threshold(STAY_SHARE * sure);
        let highest = self.look(&frame.volts, stay);
        if self.tracker.down().is_empty() && self.has_rebounded() {
            self.retaken += 1;
            self.reference = Reference::new(frame.volts.len());
            self.image = Image::blank(self.image.grid);
            self.begin(frame);
            return;
        }
        self.choose_contacts(Threshold(doubt * sure));
        self.tracker.follow(frame.t_ns, &self.contacts, changed);
        if self.tracker.down().is_empty() && highest < doubt * stay.0 {
            self.reference.follow(&frame.volts);
            self.noise_peak += NOISE_FOLLOW * (highest - self.noise_peak);
        } else {
            self.reference.hold();
        }
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

    /// Keeps the blobs that continue a touch, each touch once, and of the others those strong enough to be a new one.
    fn choose_contacts(&mut self, down: Threshold) {
        let touches = self.tracker.down();
        let mut claimed = vec![false; touches.len()];
        self.contacts.clear();
        for blob in &self.blobs {
            let near = (0..touches.len())
                .filter(|index| !claimed[*index])
                .map(|index| (distance_mm(&touches[index].contact, &blob.contact), index))
                .filter(|(distance, _)| *distance < STAY_WITHIN_MM)
                .min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, index)) = near {
                claimed[index] = true;
            }
            let is_new = blob.peak >= down.0 && !blob.may_be_ringing;
            if near.is_some() || is_new {
                self.contacts.push(blob.contact);
            }
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

    /// Channels that the first frames showed to be dead or loose, and that are left out since.
    #[must_use]
    pub fn muted_channels(&self) -> Vec<usize> {
        self.reference.muted_channels()
    }

    /// How often the reference was taken anew, because a finger had lain on the pad while it was taken.
    #[must_use]
    pub fn retaken(&self) -> u64 {
        self.retaken
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

fn distance_mm(a: &Contact, b: &Contact) -> f64 {
    let [dx, dy] = [0, 1].map(|i| a.centre_mm[i] - b.centre_mm[i]);
    libm::sqrt(dx * dx + dy * dy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{DEFAULT_PAD, Pad, shipped_pad};
    use crate::source::{Finger, Noise, SimulatedPad};
    use crate::types::{Method, Phase};

    const FRAME_NS: u64 = 10_000_000;

    struct Bench {
        pad: SimulatedPad,
        detector: Detector,
        noise: Noise,
        frame: u64,
    }

    impl Bench {
        fn new(snr_db: f64, seed: u64) -> Self {
            let shipped = shipped_pad(DEFAULT_PAD).expect("shipped");
            let pad = Pad::from_toml(shipped.name, shipped.toml).expect("sound");
            let matrix = Reconstruction::of_pad(&pad, Method::default()).expect("a matrix");
            Self {
                pad: SimulatedPad::new(&pad).expect("solvable"),
                detector: Detector::new(Arc::new(matrix)),
                noise: Noise::new(snr_db, seed),
                frame: 0,
            }
        }

        /// Plays frames of one state; returns how often touches went down and up.
        fn play(&mut self, fingers: &[Finger], frames: u64) -> (usize, usize) {
            let volts = self.pad.volts(fingers).expect("solved");
            let mut changed = Vec::new();
            for _ in 0..frames {
                let volts = self.noise.read(&volts);
                let t_ns = self.frame * FRAME_NS;
                self.detector.frame(&Frame { t_ns, volts }, &mut changed);
                self.frame += 1;
            }
            let count = |phase| changed.iter().filter(|touch| touch.phase == phase).count();
            (count(Phase::Down), count(Phase::Up))
        }
    }

    fn finger(id: u64, centre_mm: [f64; 2], radius_mm: f64, rise: f64) -> Finger {
        Finger {
            id,
            centre_mm,
            radius_mm,
            rise,
        }
    }

    #[test]
    fn a_press_held_for_a_minute_right_after_the_start_stays_one_press() {
        for seed in [1, 7] {
            let mut bench = Bench::new(60.0, seed);
            assert_eq!(bench.play(&[], 20), (0, 0));
            let press = finger(1, [80.0, 50.0], 7.0, 1.2);
            assert_eq!(bench.play(&[press], 6000), (1, 0), "seed {seed}");
            assert_eq!(
                bench.play(&[], 500),
                (0, 1),
                "seed {seed}: and leaves no ghost"
            );
        }
    }

    #[test]
    fn a_finger_that_lay_there_at_the_start_leaves_no_ghost() {
        for seed in [1, 2, 3] {
            let mut bench = Bench::new(60.0, seed);
            let early = finger(1, [80.0, 30.0], 7.0, 1.2);
            bench.play(&[early], 30);
            assert_eq!(bench.play(&[], 300), (0, 0), "seed {seed}");
            assert_eq!(bench.detector.retaken(), 1);
            let press = finger(2, [20.0, 50.0], 7.0, 1.2);
            assert_eq!(bench.play(&[press], 20), (1, 0));
            assert_eq!(bench.play(&[], 300), (0, 1));
        }
    }

    #[test]
    fn a_hard_press_does_not_lift_a_light_one() {
        let mut bench = Bench::new(60.0, 1);
        bench.play(&[], 50);
        let light = finger(1, [13.0, 57.0], 6.0, 0.3);
        let hard = finger(2, [80.0, 50.0], 9.0, 3.0);
        assert_eq!(bench.play(&[light], 50), (1, 0));
        assert_eq!(bench.play(&[light, hard], 50), (1, 0));
        assert_eq!(bench.play(&[light], 50), (0, 1));
        assert_eq!(bench.play(&[], 50), (0, 1));
    }
}
