//! The detector: its state, and the steps of a frame.

use std::sync::Arc;

use super::drawn::ImageChanges;
use super::renumbered::BoardNumbering;
use super::repeats::Repeats;
use super::shift::GainShift;
use super::sign::SignState;
use crate::eit::{ElectrodeMonitor, FirstFrames, Imager, Reconstruction, Reference};
use crate::pad::Protocol;
use crate::touch::image_locator::ImageLocator;
use crate::touch::{ChannelNoise, Correction, Locator, Sensing, Tracker};
use crate::types::{Contact, Frame, Image, NANOS_PER_MS, Nanos, Touch};

/// A frame is unexplained if its part outside of all responses exceeds noise and model error by this factor, ...
const UNEXPLAINED_OUTSIDE: f64 = 9.0;
/// ... or by this factor, while the located touches ...
const SUSPICIOUS_OUTSIDE: f64 = 3.0;
/// ... leave this many times noise and model error, more than a palm does.
const UNEXPLAINED_REST: f64 = 60.0;
/// For this many frames after the reference was taken, the noise of a board that rounds coarsely is little known, ...
const YOUNG_FRAMES: u64 = 128;
/// ... and a new touch must explain this many times as much as later.
const YOUNG_GAINS: f64 = 2.0;
/// While touches that leave this many times noise and model error are down, the reference is not updated.
const POLLUTING_REST: f64 = 10.0;
/// A change of the untouched pad that nothing explains may be a hand that no table knows: for so long the reference does not follow it.
const SUDDEN_NS: Nanos = 1_000 * NANOS_PER_MS;
/// A press that is shorter than this leaves the reference as it is: what the model does not know of many short presses would add
/// up, and the reference drifts little in this time.
const SHORT_PRESS_NS: Nanos = 300 * NANOS_PER_MS;
/// No touch changes this many readings ...
const IMPOSSIBLE_READINGS: usize = 4;
/// ... by this share ...
const IMPOSSIBLE_SHARE: f64 = 0.85;
/// ... plus this many standard deviations: a lost electrode does.
const IMPOSSIBLE_DEVIATIONS: f64 = 6.0;
/// Touches that are down wait this long for an explained frame.
const WAIT_NS: Nanos = 500 * NANOS_PER_MS;

/// Turns frames into touches.
#[derive(Clone, Debug)]
pub struct Detector {
    pub(super) sensing: Arc<Sensing>,
    pub(super) imager: Imager,
    pub(super) locator: Option<Locator>,
    pub(super) by_image: ImageLocator,
    correction: Option<Correction>,
    pub(super) reference: Reference,
    pub(super) electrodes: Option<ElectrodeMonitor>,
    pub(super) tracker: Tracker,
    /// Relative change of each channel.
    pub(super) changes: Vec<f32>,
    pub(super) image_changes: ImageChanges,
    /// Relative change of each channel that the touches explain.
    pub(super) explained: Vec<f32>,
    /// The frame without its touches, in the instrument's units.
    pub(super) untouched: Vec<f32>,
    pub(super) image: Image,
    pub(super) contacts: Vec<Contact>,
    /// The contacts of the last explained frame, before the correction.
    pub(super) uncorrected: Vec<Contact>,
    pub(super) first_frames: FirstFrames,
    /// Drive of each channel; empty if unknown.
    pub(super) drives: Vec<u16>,
    /// Whether gains of the drives look like no touch.
    pub(super) are_gains_distinct: bool,
    /// The first frames were identical, so they do not show the noise of the board.
    pub(super) noise_is_unknown: bool,
    /// Frames in a row that look like a finger that has left the pad.
    pub(super) rebounds: Vec<(Nanos, Vec<f32>)>,
    /// Frames in a row whose readings are all scaled alike.
    pub(super) shift: GainShift,
    /// Frames that come again and again.
    pub(super) repeats: Repeats,
    /// From where the board counts the electrodes.
    pub(super) numbering: BoardNumbering,
    pub(super) sign: SignState,
    /// Time of the first reference.
    pub(super) first_ns: Nanos,
    /// When the palm on the pad was first and last detected.
    pub(super) palm_ns: Option<[Nanos; 2]>,
    /// Time of the last explained frame.
    pub(super) explained_ns: Nanos,
    /// When a touch last went down or up.
    down_changed_ns: Nanos,
    /// Time of the last frame that left less than [`POLLUTING_REST`].
    well_explained_ns: Nanos,
    pub(super) frames: u64,
    /// Number of frames when the reference was taken.
    pub(super) referenced_at: u64,
    /// Deviations for which a new [`Sensing`] is wanted.
    pub(super) wanted: Option<ChannelNoise>,
    /// How often the reference was taken again.
    pub(super) references_retaken: u64,
    /// The frame is completed from parts of two: touches are found in it, but nothing is learned from it.
    pub(super) is_between: bool,
    /// How many times as much as usual a new touch must explain.
    demand: f64,
}

impl Detector {
    /// A detector that finds touches in images and does not monitor electrodes.
    #[must_use]
    pub fn new(reconstruction: Arc<Reconstruction>) -> Self {
        Self::with_monitor(Arc::new(Sensing::by_image(reconstruction)), None)
    }

    /// A detector that also monitors the electrodes of a protocol.
    #[must_use]
    pub fn for_pad(sensing: Arc<Sensing>, protocol: &Protocol) -> Self {
        Self::with_monitor(sensing, Some(protocol))
    }

    fn with_monitor(sensing: Arc<Sensing>, protocol: Option<&Protocol>) -> Self {
        let channels = sensing.channels();
        let reconstruction = &sensing.reconstruction;
        let drives = protocol.map(Protocol::drives).unwrap_or_default();
        let model = sensing.locator_model.as_deref();
        Self {
            imager: Imager::new(Arc::clone(reconstruction)),
            locator: sensing.locator_model.clone().map(Locator::new),
            by_image: ImageLocator::new(reconstruction),
            correction: None,
            reference: Reference::new(channels),
            electrodes: protocol.map(ElectrodeMonitor::new),
            tracker: Tracker::default(),
            changes: vec![0.0; channels],
            image_changes: ImageChanges::new(channels),
            explained: vec![0.0; channels],
            untouched: vec![0.0; channels],
            image: Image::blank(reconstruction.grid),
            contacts: Vec::new(),
            uncorrected: Vec::new(),
            first_frames: FirstFrames::default(),
            // Events of recordings with tables of one sign stay as they were.
            are_gains_distinct: model.is_some_and(|model| {
                model.table().has_both_signs() && model.are_gains_distinct(&drives)
            }),
            drives,
            noise_is_unknown: false,
            rebounds: Vec::new(),
            shift: GainShift::default(),
            repeats: Repeats::default(),
            numbering: protocol.map(BoardNumbering::new).unwrap_or_default(),
            sign: SignState::new(&sensing),
            first_ns: 0,
            palm_ns: None,
            explained_ns: 0,
            down_changed_ns: 0,
            well_explained_ns: 0,
            frames: 0,
            referenced_at: 0,
            wanted: None,
            references_retaken: 0,
            is_between: false,
            demand: 1.0,
            sensing,
        }
    }

    /// Corrects the places of located contacts by a calibration.
    #[must_use]
    pub fn with_correction(mut self, correction: Option<Correction>) -> Self {
        self.correction = correction;
        self
    }

    /// Replaces the sensing of the pad, for other weights; reference and touches stay.
    ///
    /// # Panics
    /// If it has another number of channels.
    pub fn set_sensing(&mut self, sensing: Arc<Sensing>) {
        assert_eq!(sensing.channels(), self.changes.len());
        let reconstruction = &sensing.reconstruction;
        self.by_image.set_reconstruction(reconstruction);
        self.imager = Imager::new(Arc::clone(reconstruction));
        match (&mut self.locator, sensing.locator_model.clone()) {
            (Some(locator), Some(model)) => locator.set_weights(model),
            (locator, model) => *locator = model.map(Locator::new),
        }
        self.sign.set_sensing(&sensing);
        self.sensing = sensing;
        self.blank_image();
        self.wanted = None;
        self.request_for_lost_channels();
    }

    /// The noise of the channels for which another [`Sensing`] is wanted, if one is.
    #[must_use]
    pub fn wanted(&self) -> Option<&ChannelNoise> {
        self.wanted.as_ref()
    }

    /// Processes a frame and appends every touch with its new phase.
    ///
    /// # Panics
    /// If the frame has another number of voltages than the pad.
    pub fn process_frame(&mut self, frame: &Frame, changed: &mut Vec<Touch>) {
        match self.numbering.place(frame) {
            Some(placed) => {
                self.process_placed(&placed, frame, changed);
                self.numbering.give_back(placed);
            }
            None => self.process_placed(frame, frame, changed),
        }
    }

    /// Like [`Detector::process_frame`], for a frame between two: its readings were used before or are used again, so nothing
    /// is learned from it about the untouched pad, and at most `most_new` touches begin, which explain `demand` times as much as usual.
    pub(in crate::touch) fn process_between(
        &mut self,
        frame: &Frame,
        (most_new, demand): (usize, f64),
        changed: &mut Vec<Touch>,
    ) {
        self.is_between = true;
        self.demand = demand;
        if let Some(locator) = &mut self.locator {
            locator.allow_new_touches(Some(most_new));
        }
        self.process_frame(frame, changed);
        self.is_between = false;
        self.demand = 1.0;
        if let Some(locator) = &mut self.locator {
            locator.allow_new_touches(None);
        }
    }

    /// Processes a frame in the order of the pad; `raw` is in that of the board.
    fn process_placed(&mut self, frame: &Frame, raw: &Frame, changed: &mut Vec<Touch>) {
        if self.is_hung(frame, changed) {
            return;
        }
        if !self.reference.is_ready() {
            if self.is_between {
                // It shares readings with others: as one of the first frames it would hide their noise.
                return;
            }
            if !self.is_back_at_old_reference(frame, changed) {
                self.take_reference_frame(frame);
                return;
            }
        }
        self.frames += 1;
        self.reference.advance(frame.t_ns);
        self.reference
            .relative_changes(&frame.volts, &mut self.changes);
        // Readings of two moments are no other board.
        let is_other = !self.is_between
            && (self.is_renumbered(raw, changed) || self.is_shifted(frame, changed));
        if is_other {
            return;
        }
        if let Some(locator) = &mut self.locator {
            locator.expect_sign(self.sign.expected);
        }
        if !self.is_between {
            self.is_back_at_old_reference(frame, changed);
        }
        self.take_out_gains();
        if let Some(mut locator) = self.locator.take_if(|_| self.tracker.down().is_empty()) {
            locator.take_untouched(&self.changes, self.noise().0);
            self.follow_deformation(&mut locator);
            self.locator = Some(locator);
        }
        if !self.is_between && self.is_rebound(frame) {
            return;
        }
        match self.locator.take() {
            Some(mut locator) => {
                self.locate(&mut locator, frame, changed);
                self.locator = Some(locator);
                self.maybe_reweight();
            }
            None => self.find_in_image(frame, changed),
        }
    }

    /// Takes the reference again from the next frames: the pad counts as untouched as it is then. Lifts all touches.
    pub fn rezero(&mut self, changed: &mut Vec<Touch>) {
        self.tracker.lift_all(changed);
        self.reset();
        if let Some(electrodes) = &mut self.electrodes {
            electrodes.reset();
        }
        self.wanted = None;
    }

    /// Locates touches in the voltages.
    fn locate(&mut self, locator: &mut Locator, frame: &Frame, changed: &mut Vec<Touch>) {
        if self.knows_both_signs() {
            let is_rounded = self.reference.is_rounded();
            let is_young = self.frames - self.referenced_at < YOUNG_FRAMES && is_rounded;
            let young_gains = if is_young { YOUNG_GAINS } else { 1.0 };
            locator.demand(self.demand * young_gains);
            locator.expect_rounding(is_rounded);
        }
        let (noise, steady) = self.noise();
        let outside = locator.take_frame(&self.changes, noise).outside;
        let is_late = self.is_late(frame);
        // The present weights are wrong until the wanted ones arrive, but the wait is limited.
        let waits_for_weights = !is_late
            && self.wanted.as_ref().is_some_and(|wanted| {
                let wanted = &wanted.deviations;
                (0..wanted.len()).any(|c| wanted[c].is_finite() != self.sensing.uses_channel(c))
            });
        let is_touched = !self.tracker.down().is_empty();
        if outside > UNEXPLAINED_OUTSIDE && self.noise_is_unknown && !is_touched {
            self.retake_reference(&[(frame.t_ns, frame.volts.clone())]);
            return;
        }
        if outside > UNEXPLAINED_OUTSIDE || waits_for_weights || self.is_impossible() {
            if self.is_contradicted(outside, changed) {
                return;
            }
            self.skip_unexplained(Some(locator), frame, changed);
            return;
        }
        let rest = locator.locate(frame.t_ns, noise, steady).rest;
        if self.is_contradicted(rest, changed)
            || self.is_lift_after_all(locator, rest, frame, changed)
        {
            return;
        }
        if rest > UNEXPLAINED_REST && outside > SUSPICIOUS_OUTSIDE {
            locator.undo_frame();
            self.skip_unexplained(Some(locator), frame, changed);
            return;
        }
        self.follow_deformation(locator);
        self.follow_touches(locator, rest, frame, changed);
    }

    /// Follows the touches that explain a frame up to `rest` times noise and model error.
    fn follow_touches(
        &mut self,
        locator: &mut Locator,
        rest: f64,
        frame: &Frame,
        changed: &mut Vec<Touch>,
    ) {
        self.explained_ns = frame.t_ns;
        locator.explain(&mut self.explained);
        self.contacts.clear();
        self.contacts.extend(locator.contacts());
        self.uncorrected.clone_from(&self.contacts);
        if let Some(correction) = &mut self.correction {
            correction.apply(&self.changes, &mut self.contacts);
        }
        self.keep_image_changes();
        if self.is_under_palm(rest, frame.t_ns) {
            self.uncorrected.clone_from(&self.contacts);
            self.handle_palm(frame, changed);
            return;
        }
        let were_down = self.tracker.down().len();
        self.tracker.follow(frame.t_ns, &self.contacts, changed);
        if self.tracker.down().len() < were_down {
            // The gel springs back.
            self.reference.skip_frame();
        }
        if self.learn_sign(were_down, rest, frame, changed) {
            return;
        }
        if let Some(electrodes) = &mut self.electrodes {
            electrodes.accept_frame();
        }
        self.watch_lost_electrodes(frame);
        if self.tracker.down().len() != were_down {
            self.down_changed_ns = frame.t_ns;
        }
        if self.is_between {
            return;
        }
        self.find_reconnected_electrode(frame);
        // What the touches leave must not become part of the reference.
        let held_ns = frame.t_ns.saturating_sub(self.down_changed_ns);
        let is_explained = rest < POLLUTING_REST;
        if is_explained {
            self.well_explained_ns = frame.t_ns;
        }
        let is_sudden = frame.t_ns.saturating_sub(self.well_explained_ns) < SUDDEN_NS;
        let is_clean = if self.tracker.down().is_empty() {
            is_explained || !is_sudden
        } else {
            is_explained && held_ns >= SHORT_PRESS_NS
        };
        if is_clean || !self.knows_both_signs() {
            self.follow_reference(frame);
        }
    }

    /// Moves the reference by the deformation of the pad that the locator found in the frame.
    fn follow_deformation(&mut self, locator: &mut Locator) {
        if self.is_between {
            return;
        }
        locator.keep_deformation();
        if let Some(deformation) = locator.deformation() {
            self.reference.shift(&deformation, &mut self.changes);
        }
    }

    /// Whether too many readings changed more than touches can change them.
    fn is_impossible(&self) -> bool {
        self.is_beyond(IMPOSSIBLE_SHARE)
    }

    /// Whether too many readings changed more than the lift of fingers that the reference was taken under can change them: seen from the
    /// untouched pad, by more than touches can.
    pub(super) fn is_impossible_lift(&self) -> bool {
        self.is_beyond(IMPOSSIBLE_SHARE / (1.0 - IMPOSSIBLE_SHARE))
    }

    /// Whether too many readings fell by more than touches can lower them, or rose by more than this share.
    fn is_beyond(&self, most_rise: f64) -> bool {
        let impossible = (0..self.changes.len()).filter(|channel| {
            let [noise, doubt] = self.reference.variances(*channel);
            let change = f64::from(self.changes[*channel]);
            let doubt = IMPOSSIBLE_DEVIATIONS * libm::sqrt(noise + doubt);
            let possible = -IMPOSSIBLE_SHARE - doubt..=most_rise + doubt;
            !possible.contains(&change)
        });
        impossible.count() >= IMPOSSIBLE_READINGS
    }

    /// Whether touches have waited too long for an explained frame.
    fn is_late(&self, frame: &Frame) -> bool {
        frame.t_ns.saturating_sub(self.explained_ns) > WAIT_NS
    }

    /// Skips a frame that no set of touches explains: no touch begins, and those that are down wait until the frame is late.
    fn skip_unexplained(
        &mut self,
        locator: Option<&mut Locator>,
        frame: &Frame,
        changed: &mut Vec<Touch>,
    ) {
        if !self.is_between {
            self.find_faulty_electrode(frame);
        }
        self.keep_image_changes();
        if self.is_late(frame) {
            self.tracker.lift_all(changed);
            if let Some(locator) = locator {
                locator.forget_touches();
            }
            self.explained.fill(0.0);
            return;
        }
        self.contacts.clear();
        let down = self.tracker.down().iter().map(|touch| touch.contact);
        self.contacts.extend(down);
        self.tracker.follow(frame.t_ns, &self.contacts, changed);
    }

    /// Finds touches in the image.
    fn find_in_image(&mut self, frame: &Frame, changed: &mut Vec<Touch>) {
        if self.is_impossible() {
            if self.electrodes.is_some() && !self.is_late(frame) {
                self.skip_unexplained(None, frame, changed);
                return;
            }
        } else {
            self.explained_ns = frame.t_ns;
        }
        self.keep_image_changes();
        self.draw_image();
        let doubt = self.reference.doubt();
        let down = self.tracker.down();
        let is_quiet = self
            .by_image
            .contacts(&self.image, doubt, down, &mut self.contacts);
        self.uncorrected.clone_from(&self.contacts);
        self.tracker.follow(frame.t_ns, &self.contacts, changed);
        if let Some(electrodes) = &mut self.electrodes {
            electrodes.accept_frame();
        }
        if self.tracker.down().is_empty() && is_quiet {
            self.watch_lost_electrodes(frame);
            self.find_reconnected_electrode(frame);
            self.reference.update(&frame.volts, &self.explained);
        } else {
            self.reference.skip_frame();
        }
    }

    /// Lifts every touch, because the source disconnected.
    pub fn lift_all(&mut self, changed: &mut Vec<Touch>) {
        self.tracker.lift_all(changed);
        if let Some(locator) = &mut self.locator {
            locator.forget_touches();
        }
    }
}
