//! Frames that are read drive by drive: touches are seen while their frame is still being read.
//!
//! A board reads one drive after another, so a frame is not a moment: half of it may show a finger that the other half does not.
//! A [`Scan`] keeps for every reading the response of the touches that it is believed to contain. When the readings since some
//! moment show that a finger went down or lifted, the older ones are brought to the present by adding or removing its response,
//! and readings of a moving finger are moved on with it. The completed frame, in which everything belongs to one moment, goes to
//! the [`Detector`], which decides as it does for any other frame.
//!
//! Invariant: a whole frame without such a change reaches the detector as it was read.

mod drift;
mod evidence;
mod fit;
mod landing;
mod moves;
mod onset;
mod readings;
mod refusals;
mod release;

use crate::touch::Detector;
use crate::types::{Frame, NANOS_PER_MS, Nanos, Part, Phase, Touch};
use drift::{Drift, Ways};
use evidence::{Candidate, Evidence};
use fit::{FitMemory, Fitted};
use landing::Landing;
use onset::OnsetModel;
use refusals::Refusals;

/// While a touch moves, or something changes that is not yet clear, places are found once in this many parts.
const MOVING_PARTS: usize = 2;
/// A change that is not yet clear is looked at once in this time at most: fast boards send more parts than it needs.
const UNCLEAR_NS: Nanos = 2 * NANOS_PER_MS;
/// So many frames may end amid a change before they count as they are: an electrode may have gone.
const UNCLEAR_FRAMES: u32 = 3;

/// A frame is brought to the present with a velocity that may be wrong. A touch that begins in it was not shown by its own parts, so it
/// must explain so many times as much as usual.
const MOVED_DEMAND: f64 = 4.0;

/// The readings of the last frame, and what they are believed to contain.
#[derive(Clone, Debug, Default)]
pub struct Scan {
    /// The last reading of each channel, ...
    volts: Vec<f32>,
    /// ... when it was taken, ...
    read_ns: Vec<Nanos>,
    /// ... the relative change by touches that it contains, ...
    contained: Vec<f32>,
    /// ... and whether those are the touches that are down now.
    is_current: Vec<bool>,
    /// The relative change of each channel by the touches that are down, at the time of the last run, ...
    expected: Vec<f32>,
    /// ... how it changes while they move, ...
    ways: Ways,
    drift: Drift,
    /// ... and the time of that run.
    run_ns: Nanos,
    /// What the parts since then show beside them.
    evidence: Evidence,
    onsets: Option<OnsetModel>,
    refusals: Refusals,
    /// A finger that landed less than a frame ago.
    landing: Landing,
    memory: FitMemory,
    /// Whether each channel was ever read, ...
    is_read: Vec<bool>,
    /// ... and how many were not.
    unread: usize,
    /// Readings that are not current are from before a lift: what the gone finger leaves in them is not a touch.
    is_after_lift: bool,
    /// The detector found no lift in this frame where the parts show one.
    has_failed_lift: bool,
    /// Parts since the detector last ran.
    parts: usize,
    /// Frames in a row that ended amid a change that was not yet clear.
    unclear_frames: u32,
    completed: Frame,
}

/// What the detector runs on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Run {
    /// A frame that was read to its end.
    Whole,
    /// The same, brought to the present with a moving finger: nothing is learned from it.
    Moved,
    /// The same, amid a change that is not yet clear: no touch begins. One that does is found by its own parts.
    Unclear,
    /// Readings of two frames, with the touches that are known.
    Between,
    /// The same, in which a finger has lifted.
    Lift,
    /// The same, in which a finger has landed.
    Landing,
}

impl Run {
    /// Whether it is at the end of a frame, or starts anew with a finger that has landed.
    fn is_at_end(self) -> bool {
        matches!(
            self,
            Self::Whole | Self::Moved | Self::Unclear | Self::Landing
        )
    }
}

impl Scan {
    /// Processes a part of a frame and appends every touch whose phase changes.
    ///
    /// # Panics
    /// If the part reaches beyond the pad's channels, which sources prevent.
    pub fn process_part(&mut self, detector: &mut Detector, part: &Part, changed: &mut Vec<Touch>) {
        let ends_frame = self.keep(detector, part);
        if !self.can_look_inside(detector) {
            if ends_frame && self.unread == 0 {
                self.run(detector, part.t_ns, Run::Whole, changed);
            }
            return;
        }
        self.follow_landing(detector, part);
        self.add_evidence(detector, part);
        if let Some(gone) = self.find_lift() {
            let were_down = detector.touches_down().len();
            self.mark_since(gone.parts);
            self.landing.end();
            self.refusals.clear();
            let response = self.evidence.held(gone.response);
            for (expected, gone) in self.expected.iter_mut().zip(response) {
                *expected -= gone;
            }
            self.is_after_lift = true;
            self.run(detector, part.t_ns, Run::Lift, changed);
            self.has_failed_lift = detector.touches_down().len() == were_down;
            self.is_after_lift &= !self.has_failed_lift;
            if !self.has_failed_lift {
                self.unclear_frames = 0;
            }
            return;
        }
        let fits = self.refusals.count();
        if let Some((fitted, since)) = self.find_onset(detector) {
            self.mark_since(since);
            self.is_after_lift = false;
            self.refusals.clear();
            self.begin_landing(fitted, since);
            self.run(detector, part.t_ns, Run::Landing, changed);
        } else if ends_frame || self.refusals.count() == fits {
            self.run_when_due(detector, part.t_ns, ends_frame, changed);
        } else {
            // A refused fit took as long as a run: that is for the next part.
            self.parts += 1;
        }
    }

    /// Processes a frame that was read as a whole, between others that came in parts or not.
    ///
    /// # Panics
    /// If the frame has another number of voltages than the pad.
    pub fn process_frame(
        &mut self,
        detector: &mut Detector,
        frame: &Frame,
        changed: &mut Vec<Touch>,
    ) {
        if self.volts.len() != frame.volts.len() {
            detector.process_frame(frame, changed);
            return;
        }
        self.volts.copy_from_slice(&frame.volts);
        self.read_ns.fill(frame.t_ns);
        self.is_current.fill(true);
        self.is_read.fill(true);
        self.unread = 0;
        self.landing.end();
        self.evidence.clear();
        self.unclear_frames = 0;
        self.run(detector, frame.t_ns, Run::Whole, changed);
    }

    /// Runs the detector at the end of a frame, and more often while something moves or lands.
    fn run_when_due(
        &mut self,
        detector: &mut Detector,
        t_ns: Nanos,
        ends_frame: bool,
        changed: &mut Vec<Touch>,
    ) {
        self.parts += 1;
        let since_ns = t_ns.saturating_sub(self.run_ns);
        let is_touched = self.evidence.held_count() > 0;
        let is_unclear = self.evidence.is_unclear();
        if self.landing.is_active() {
            self.run(detector, t_ns, Run::Between, changed);
        } else if ends_frame {
            // A change that is under way is neither a fault of an electrode nor the untouched pad.
            self.unclear_frames = if is_unclear {
                self.unclear_frames + 1
            } else {
                0
            };
            let is_moving = !self.ways.is_empty();
            let is_mixed = !self.is_current.iter().all(|is_current| *is_current);
            match self.unclear_frames {
                1 if !is_touched => {}
                // A moving finger that lifts looks like two for a moment.
                1..=UNCLEAR_FRAMES if is_moving => self.run(detector, t_ns, Run::Unclear, changed),
                1..=UNCLEAR_FRAMES => self.run(detector, t_ns, Run::Landing, changed),
                _ if is_mixed => self.run(detector, t_ns, Run::Landing, changed),
                _ if is_moving => self.run(detector, t_ns, Run::Moved, changed),
                _ => self.run(detector, t_ns, Run::Whole, changed),
            }
        } else if is_touched
            && self.parts >= MOVING_PARTS
            && (!self.ways.is_empty() || (is_unclear && since_ns >= UNCLEAR_NS))
        {
            self.run(detector, t_ns, Run::Between, changed);
        }
    }

    /// Forgets everything: the reference is taken again.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Keeps the readings; whether they are the last of a frame.
    fn keep(&mut self, detector: &Detector, part: &Part) -> bool {
        let channels = detector.channels();
        if self.volts.len() != channels {
            self.volts = vec![0.0; channels];
            self.read_ns = vec![0; channels];
            self.contained = vec![0.0; channels];
            self.expected = vec![0.0; channels];
            self.is_current = vec![true; channels];
            self.is_read = vec![false; channels];
            self.unread = channels;
        }
        let span = part.first..part.first + part.volts.len();
        self.volts[span.clone()].copy_from_slice(&part.volts);
        self.read_ns[span.clone()].fill(part.t_ns);
        self.is_current[span.clone()].fill(true);
        self.contained[span.clone()].copy_from_slice(&self.expected[span.clone()]);
        if self.unread > 0 {
            self.is_read[span.clone()].fill(true);
            self.unread = self.is_read.iter().filter(|is_read| !**is_read).count();
        }
        span.end == channels
    }

    /// Whether parts say more than frames: there is a reference and a table, and parts are in the pad's order.
    fn can_look_inside(&self, detector: &Detector) -> bool {
        detector.is_ready()
            && self.unread == 0
            && detector.locator().is_some()
            && detector.is_in_own_order()
    }

    /// Adds the readings of a part, without the touches that are down, to the evidence.
    fn add_evidence(&mut self, detector: &Detector, part: &Part) {
        let Some(locator) = detector.locator() else {
            return;
        };
        let sign = detector.touch_sign();
        if self
            .onsets
            .as_ref()
            .is_none_or(|model| !model.is_for(locator, sign))
        {
            self.onsets = Some(OnsetModel::new(locator, sign));
            self.evidence.clear();
        }
        let Some(model) = &self.onsets else {
            return;
        };
        let expected = |channel: usize| {
            let moved = self.ways.change(channel, self.run_ns, part.t_ns);
            self.expected[channel] + moved
        };
        self.evidence
            .add(detector, model.responses(), part, expected);
    }

    /// A finger that lifted. If the detector did not agree, it is asked again when the frame is complete.
    fn find_lift(&self) -> Option<Candidate> {
        release::find(&self.evidence, !self.ways.is_empty()).filter(|_| !self.has_failed_lift)
    }

    /// A finger that went down, and how many parts ago. While one lands, no other is looked for.
    fn find_onset(&mut self, detector: &Detector) -> Option<(Fitted, usize)> {
        if self.landing.is_active() {
            return None;
        }
        let model = self.onsets.as_ref()?;
        let (refusals, memory) = (&mut self.refusals, &mut self.memory);
        model.find(detector, &self.evidence, refusals, memory)
    }

    /// A finger that went down `since` parts ago lands.
    fn begin_landing(&mut self, fitted: Fitted, since: usize) {
        if let Some(model) = &self.onsets {
            let readings = self.evidence.readings(since);
            let (expected, memory) = (&self.expected, &mut self.memory);
            self.landing
                .begin(fitted, model, readings, expected, memory);
            self.take_landing();
        }
    }

    /// Fits a finger that has just landed again: it may already slide.
    fn follow_landing(&mut self, detector: &Detector, part: &Part) {
        let Some(model) = self.onsets.as_ref().filter(|_| self.landing.is_active()) else {
            return;
        };
        let is_read = self.landing.add(detector, part);
        self.landing.fit(model, &mut self.memory);
        self.take_landing();
        if is_read {
            self.landing.end();
        }
    }

    /// The channels are expected to change as the landing finger changes them.
    fn take_landing(&mut self) {
        for (channel, expected) in self.expected.iter_mut().enumerate() {
            *expected = self.landing.expected(channel);
        }
    }

    /// Only the readings of the last `parts` parts belong to the present touches.
    fn mark_since(&mut self, parts: usize) {
        for (channel, is_current) in self.is_current.iter_mut().enumerate() {
            if *is_current && !self.evidence.contains(parts, channel) {
                *is_current = false;
            }
        }
    }

    /// Brings every reading to the present.
    fn complete(&mut self, detector: &Detector, t_ns: Nanos) {
        let reference = detector.reference().volts();
        self.completed.t_ns = t_ns;
        self.completed.volts.clone_from(&self.volts);
        for (channel, volt) in self.completed.volts.iter_mut().enumerate() {
            let moved = if !self.is_current[channel] && self.is_after_lift {
                *volt = (reference[channel] * f64::from(1.0 + self.expected[channel])) as f32;
                0.0
            } else if !self.is_current[channel] {
                self.expected[channel] - self.contained[channel]
            } else {
                self.ways.change(channel, self.read_ns[channel], t_ns)
            };
            if moved != 0.0 {
                *volt += reference[channel] as f32 * moved;
            }
        }
    }

    /// Runs the detector on the frame as it would be now.
    fn run(&mut self, detector: &mut Detector, t_ns: Nanos, run: Run, changed: &mut Vec<Touch>) {
        self.complete(detector, t_ns);
        match run {
            Run::Whole => detector.process_frame(&self.completed, changed),
            Run::Between | Run::Lift | Run::Unclear => {
                detector.process_between(&self.completed, (0, 1.0), changed);
            }
            Run::Landing => detector.process_between(&self.completed, (1, 1.0), changed),
            Run::Moved => {
                detector.process_between(&self.completed, (1, MOVED_DEMAND), changed);
            }
        }
        self.expected.fill(0.0);
        if !detector.touches_down().is_empty() {
            self.expected.copy_from_slice(detector.explained());
        }
        for (channel, contained) in self.contained.iter_mut().enumerate() {
            if self.is_current[channel] {
                *contained = self.expected[channel];
            }
        }
        self.run_ns = t_ns;
        let down = detector.touches_down();
        let ups = changed.iter().filter(|touch| touch.phase == Phase::Up);
        let mut is_fewer = false;
        for gone in ups {
            self.drift.forget(gone);
            is_fewer = true;
        }
        let has_landed = changed.iter().any(|touch| touch.phase == Phase::Down);
        if self.landing.is_active() || (run == Run::Landing && has_landed) {
            self.drift.clear();
            self.ways.clear();
        } else {
            if run.is_at_end() && !is_fewer {
                self.drift.take(t_ns, down);
            }
            if run.is_at_end() || is_fewer {
                self.drift.ways(t_ns, detector.locator(), &mut self.ways);
            }
        }
        if run.is_at_end() {
            self.has_failed_lift = false;
            self.refusals.clear();
            // A frame that nothing explains says no more about what changed than its parts.
            if detector.explained_ns() == t_ns {
                self.evidence.clear();
            }
        }
        self.evidence.set_held(detector);
        self.parts = 0;
    }
}
