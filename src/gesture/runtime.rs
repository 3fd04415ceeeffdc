//! Runs bindings: gives each change of a finger to the recognizers of the bindings that it concerns.

use super::accept::AcceptedTouch;
use super::binding_index::BindingIndex;
use super::driver::Driver;
use super::fingers::{Finger, Fingers, TouchSample};
use super::layout::Covered;
use super::moment::Moment;
use super::recognizers::{self, ActiveRecognizer, Playing, TapMemory, TouchGroup};
use crate::profile::{Gesture, Profile, Target};
use crate::types::{Nanos, Phase, TouchId};

/// Touches that can play one binding at once without an allocation.
const TOUCHES_PER_BINDING: usize = 10;

/// Fingers, the gestures that they have begun, and what these drive.
#[derive(Clone, Debug)]
pub(super) struct BindingRuntime {
    pub(super) driver: Driver,
    /// Only the gesture that ends the pause counts.
    pub(super) paused: bool,
    fingers: Fingers,
    active: Vec<ActiveGesture>,
    index: BindingIndex,
    /// The taps of each binding.
    taps: Vec<TapMemory>,
    /// When any binding was pressed last.
    last_press_ns: Option<Nanos>,
}

/// A binding that a touch (or a group of touches) plays.
#[derive(Clone, Copy, Debug)]
struct ActiveGesture {
    /// The touch; of a group, the one that completed it.
    touch: TouchId,
    binding: usize,
    /// None for the whole pad.
    region: Option<usize>,
    is_group: bool,
    recognizer: ActiveRecognizer,
}

impl BindingRuntime {
    pub(super) fn new(profile: &Profile) -> Self {
        Self {
            driver: Driver::new(profile),
            paused: false,
            fingers: Fingers::new(),
            active: Vec::with_capacity(TOUCHES_PER_BINDING * profile.bindings.len()),
            index: BindingIndex::new(profile),
            taps: vec![TapMemory::default(); profile.bindings.len()],
            last_press_ns: None,
        }
    }

    pub(super) fn is_idle(&self) -> bool {
        self.driver.is_idle()
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        let active = self.active.iter();
        let recognizers = active.filter_map(|active| active.recognizer.next_due());
        recognizers.chain(self.driver.next_due()).min()
    }

    /// Ends every gesture; fingers that are down play nothing more.
    pub(super) fn release_all(&mut self, moment: &mut Moment<'_>) {
        self.active.clear();
        self.taps.fill(TapMemory::default());
        self.last_press_ns = None;
        self.driver.release_all(moment);
    }

    pub(super) fn forget_fingers(&mut self) {
        self.fingers.clear();
    }

    /// Makes the decisions that are due.
    pub(super) fn tick(&mut self, moment: &mut Moment<'_>) {
        for at in 0..self.active.len() {
            self.with_recognizer(moment, at, ActiveRecognizer::tick);
        }
        self.driver.tick(moment);
    }

    /// A finger that counts went down, moved or lifted.
    pub(super) fn finger(&mut self, moment: &mut Moment<'_>, accepted: &AcceptedTouch) {
        match accepted.phase {
            Phase::Down => self.down(moment, accepted),
            Phase::Move => self.moved(moment, accepted),
            Phase::Up => self.up(moment, accepted.id),
        }
    }

    fn down(&mut self, moment: &mut Moment<'_>, accepted: &AcceptedTouch) {
        let covered = match accepted.part {
            Some(place) => Covered::only(place),
            None => moment.layout.covered(accepted.at_mm, accepted.radius_mm),
        };
        let finger = self.fingers.add(moment.t_ns, accepted, covered);
        self.notify_others(moment, finger.id, ActiveRecognizer::other_down);
        for place in covered.iter() {
            self.enter_place(moment, place, &finger);
        }
        if !finger.is_part {
            self.enter_pad(moment, &finger);
        }
        self.update_groups(moment, finger.id);
    }

    fn moved(&mut self, moment: &mut Moment<'_>, accepted: &AcceptedTouch) {
        let layout = moment.layout;
        let Some(finger) = self.fingers.get_mut(accepted.id) else {
            return;
        };
        let before = finger.covered;
        finger.at_mm = accepted.at_mm;
        finger.force = accepted.force;
        if accepted.part.is_none() {
            finger.covered = layout.moved(before, accepted.at_mm, accepted.radius_mm);
        }
        let finger = *finger;
        let covered = finger.covered;
        if covered != before {
            self.end_where(moment, |active| {
                let left = active.region.is_some_and(|place| !covered.contains(place));
                !active.is_group && active.touch == finger.id && left
            });
        }
        for at in 0..self.active.len() {
            self.follow(moment, at, &finger);
        }
        if covered != before {
            for place in covered.iter().filter(|place| !before.contains(*place)) {
                self.enter_place(moment, place, &finger);
            }
            self.update_groups(moment, finger.id);
        }
    }

    fn up(&mut self, moment: &mut Moment<'_>, id: TouchId) {
        self.end_where(moment, |active| !active.is_group && active.touch == id);
        self.fingers.remove(id);
        self.update_groups(moment, id);
        self.notify_others(moment, id, ActiveRecognizer::other_up);
    }

    /// A finger went down on the pad: starts the bindings without a place.
    fn enter_pad(&mut self, moment: &mut Moment<'_>, finger: &Finger) {
        for listed in 0..self.index.whole_pad.len() {
            let index = self.index.whole_pad[listed];
            if self.counts(moment.profile, index, None) {
                self.start(moment, index, &finger.sample(None));
            }
        }
    }

    /// A finger came to a region, or a part of a gamepad was moved: starts the bindings of that place.
    fn enter_place(&mut self, moment: &mut Moment<'_>, place: usize, finger: &Finger) {
        for listed in 0..self.index.by_place[place].len() {
            let index = self.index.by_place[place][listed];
            if self.counts(moment.profile, index, Some(place)) {
                self.start(moment, index, &finger.sample(Some(place)));
            }
        }
    }

    /// Whether a binding counts: on the topmost layer that is on and binds the place, and not in a pause.
    fn counts(&self, profile: &Profile, index: usize, place: Option<usize>) -> bool {
        let binding = &profile.bindings[index];
        if self.paused && !binding.targets.contains(&Target::Pause) {
            return false;
        }
        if profile.layers.is_empty() {
            return true;
        }
        let is_on = |layer: Option<usize>| layer.is_none_or(|layer| self.driver.is_on(layer));
        let Some(place) = place else {
            return is_on(binding.layer);
        };
        let all = profile.bindings.iter().zip(&self.index.places);
        let top = all
            .filter(|(_, places)| places.contains(&place))
            .map(|(other, _)| other.layer)
            .filter(|layer| is_on(*layer))
            .max();
        top == Some(binding.layer)
    }

    fn is_played(&self, index: usize) -> bool {
        self.active.iter().any(|active| active.binding == index)
    }

    /// A touch begins to play a binding.
    fn start(&mut self, moment: &mut Moment<'_>, index: usize, touch: &TouchSample) {
        let gesture = &moment.profile.bindings[index].gesture;
        if recognizers::takes_one_touch(gesture) && self.is_played(index) {
            return;
        }
        let mut playing = Playing {
            moment,
            driver: &mut self.driver,
            taps: &mut self.taps[index],
            last_press_ns: &mut self.last_press_ns,
            binding: index,
            touch: touch.id,
        };
        let recognizer = ActiveRecognizer::down(gesture, touch, &mut playing);
        self.active.push(ActiveGesture {
            touch: touch.id,
            binding: index,
            region: touch.place,
            is_group: recognizers::is_group(gesture),
            recognizer,
        });
    }

    /// A finger moved: tells a gesture that it or its group plays.
    fn follow(&mut self, moment: &mut Moment<'_>, at: usize, finger: &Finger) {
        let active = self.active[at];
        let sample = if active.is_group {
            let regions = &moment.profile.bindings[active.binding].regions;
            self.fingers.group_sample(active.touch, regions)
        } else if active.touch == finger.id {
            finger.sample(active.region)
        } else {
            return;
        };
        self.with_recognizer(moment, at, |recognizer, gesture, playing| {
            recognizer.moved(gesture, &sample, playing);
        });
    }

    /// A finger came, left or changed regions: starts and ends the gestures of several touches.
    fn update_groups(&mut self, moment: &mut Moment<'_>, id: TouchId) {
        let profile = moment.profile;
        for listed in 0..self.index.groups.len() {
            let index = self.index.groups[listed];
            let binding = &profile.bindings[index];
            let is_played = self.is_played(index);
            let group = TouchGroup {
                fingers: &self.fingers,
                places: &self.index.places[index],
                regions: &binding.regions,
                is_played,
            };
            let is_complete = recognizers::is_complete(&binding.gesture, &group);
            let place = self.index.places[index].first().copied();
            if is_complete && !is_played && self.counts(profile, index, place) {
                let sample = self.fingers.group_sample(id, &binding.regions);
                self.start(moment, index, &sample);
            } else if !is_complete && is_played {
                self.end_where(moment, |active| active.binding == index);
            }
        }
    }

    /// Ends gestures: their touch has lifted or left its region, or their group is no longer complete.
    fn end_where(&mut self, moment: &mut Moment<'_>, ends: impl Fn(&ActiveGesture) -> bool) {
        let mut at = 0;
        while at < self.active.len() {
            if ends(&self.active[at]) {
                self.with_recognizer(moment, at, |recognizer, gesture, playing| {
                    recognizer.up(gesture, playing);
                    playing.release();
                });
                self.active.remove(at);
            } else {
                at += 1;
            }
        }
    }

    /// Tells the gestures of all other touches that a touch went down or lifted.
    fn notify_others(
        &mut self,
        moment: &mut Moment<'_>,
        id: TouchId,
        notify: fn(&mut ActiveRecognizer, &Gesture, TouchId, &mut Playing<'_, '_>),
    ) {
        for at in 0..self.active.len() {
            if self.active[at].touch != id {
                self.with_recognizer(moment, at, |recognizer, gesture, playing| {
                    notify(recognizer, gesture, id, playing);
                });
            }
        }
    }

    fn with_recognizer(
        &mut self,
        moment: &mut Moment<'_>,
        at: usize,
        act: impl FnOnce(&mut ActiveRecognizer, &Gesture, &mut Playing<'_, '_>),
    ) {
        let active = &mut self.active[at];
        let gesture = &moment.profile.bindings[active.binding].gesture;
        let mut playing = Playing {
            moment,
            driver: &mut self.driver,
            taps: &mut self.taps[active.binding],
            last_press_ns: &mut self.last_press_ns,
            binding: active.binding,
            touch: active.touch,
        };
        act(&mut active.recognizer, gesture, &mut playing);
    }
}
