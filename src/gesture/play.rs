//! Fingers play bindings: what each change of a finger means for every gesture that it has begun.

use super::accept::{Passed, distance_mm};
use super::active::{Active, State};
use super::begin::Index;
use super::double_tap::DoubleTap;
use super::drive::Driver;
use super::fingers::{Finger, Fingers};
use super::force;
use super::layout::Covered;
use super::step::Step;
use super::tap_hold::{Decision, Side, Undecided};
use super::{dpad, stick};
use crate::profile::{Gesture, Profile, Target};
use crate::types::{Event, Nanos, Phase, TouchId};

/// Touches that may play one binding at once, for which there is room from the start.
const ROOM_A_BINDING: usize = 10;

/// Fingers, the gestures that they have begun, and what these drive.
#[derive(Clone, Debug)]
pub(super) struct Players {
    pub(super) driver: Driver,
    /// Nothing counts but the gesture that ends the pause.
    pub(super) paused: bool,
    pub(super) fingers: Fingers,
    pub(super) active: Vec<Active>,
    pub(super) index: Index,
    /// When a tap by each binding ended last.
    pub(super) last_tap: Vec<Option<Nanos>>,
    /// When any binding was pressed last.
    pub(super) last_press: Option<Nanos>,
}

impl Players {
    pub(super) fn new(profile: &Profile) -> Self {
        Self {
            driver: Driver::new(profile),
            paused: false,
            fingers: Fingers::new(),
            active: Vec::with_capacity(ROOM_A_BINDING * profile.bindings.len()),
            index: Index::new(profile),
            last_tap: vec![None; profile.bindings.len()],
            last_press: None,
        }
    }

    pub(super) fn is_idle(&self) -> bool {
        self.driver.is_idle()
    }

    pub(super) fn next_due(&self) -> Option<Nanos> {
        let active = self.active.iter().filter_map(Active::next_due);
        active.chain(self.driver.next_due()).min()
    }

    /// Ends every gesture; fingers that are down stay known, and give nothing more.
    pub(super) fn release_all(&mut self, step: &mut Step<'_>) {
        self.active.clear();
        self.last_tap.fill(None);
        self.last_press = None;
        self.driver.release_all(step);
    }

    pub(super) fn forget_fingers(&mut self) {
        self.fingers.clear();
    }

    /// Makes the decisions that fall due.
    pub(super) fn tick(&mut self, step: &mut Step<'_>) {
        let t_ns = step.t_ns;
        for at in 0..self.active.len() {
            let active = &mut self.active[at];
            let decision = match &mut active.state {
                State::Hold(hold) => begin_if(hold.tick(t_ns)),
                State::TapHold(undecided) => undecided.tick(t_ns),
                _ => Decision::None,
            };
            self.carry_out(step, at, decision);
        }
        self.driver.tick(step);
    }

    /// Takes what became of a finger that counts.
    pub(super) fn finger(&mut self, step: &mut Step<'_>, passed: &Passed) {
        match passed.phase {
            Phase::Down => self.down(step, passed),
            Phase::Move => self.moved(step, passed),
            Phase::Up => self.up(step, passed.id),
        }
    }

    fn down(&mut self, step: &mut Step<'_>, passed: &Passed) {
        let Step { layout, t_ns, .. } = *step;
        let covered = match passed.part {
            Some(place) => Covered::only(place),
            None => layout.covered(passed.at_mm, passed.radius_mm),
        };
        let finger = self.fingers.add(t_ns, passed, covered);
        self.tell_others(step, passed.id, Undecided::other_down);
        for region in covered.iter() {
            self.enter(step, region, &finger);
        }
        if !finger.is_part {
            self.enter_pad(step, &finger);
        }
        self.gather(step, passed.id);
    }

    fn moved(&mut self, step: &mut Step<'_>, passed: &Passed) {
        let layout = step.layout;
        let Some(finger) = self.fingers.get_mut(passed.id) else {
            return;
        };
        let before = finger.covered;
        let covered = match passed.part {
            Some(_) => before,
            None => layout.moved(before, passed.at_mm, passed.radius_mm),
        };
        finger.at_mm = passed.at_mm;
        finger.force = passed.force;
        finger.covered = covered;
        let finger = *finger;
        if covered != before {
            let left =
                |region: Option<usize>| region.is_some_and(|region| !covered.contains(region));
            self.end_where(step, |active| {
                active.touch == finger.id && left(active.region)
            });
        }
        for at in 0..self.active.len() {
            self.follow(step, at, &finger);
        }
        if covered != before {
            for region in covered.iter().filter(|region| !before.contains(*region)) {
                self.enter(step, region, &finger);
            }
            self.gather(step, finger.id);
        }
    }

    fn up(&mut self, step: &mut Step<'_>, id: TouchId) {
        self.end_where(step, |active| active.touch == id);
        self.fingers.remove(id);
        self.gather(step, id);
        self.tell_others(step, id, Undecided::other_up);
    }

    /// A finger has moved: what that means for a gesture.
    pub(super) fn follow(&mut self, step: &mut Step<'_>, at: usize, finger: &Finger) {
        let Step { profile, t_ns, .. } = *step;
        let Active {
            touch,
            binding: index,
            ..
        } = self.active[at];
        let binding = &profile.bindings[index];
        let state = &mut self.active[at].state;
        if let (State::CrowdSwipe(stroke), Gesture::Swipe(own)) = (&mut *state, &binding.gesture) {
            let middle_mm = self.fingers.middle(&binding.regions);
            if stroke.moved(own, middle_mm, t_ns) {
                self.carry_out(step, at, Decision::Begin(Side::First));
            }
            return;
        }
        if touch != finger.id {
            return;
        }
        let moved_mm = distance_mm(finger.first_mm, finger.at_mm);
        let decision = match (state, &binding.gesture) {
            (State::Tap(tap) | State::DoubleTap(DoubleTap::First(tap)), _) => {
                tap.moved(moved_mm);
                Decision::None
            }
            (State::Hold(hold), _) => {
                hold.moved(moved_mm);
                Decision::None
            }
            (State::Swipe(stroke), Gesture::Swipe(own)) => {
                begin_if(stroke.moved(own, finger.at_mm, t_ns))
            }
            (State::Force { down }, Gesture::Force { press, release }) => {
                let before = *down;
                *down = force::is_down(before, finger.force, *press, *release);
                let now = *down;
                if before && !now {
                    self.driver.end(step, index, touch);
                }
                begin_if(now && !before)
            }
            (
                State::Dpad {
                    down,
                    middle_mm,
                    radius_mm,
                },
                Gesture::Dpad(own),
            ) => {
                let offset = [0, 1].map(|i| finger.at_mm[i] - middle_mm[i]);
                let now = dpad::directions(own, offset, *radius_mm);
                let before = std::mem::replace(down, now);
                self.turn(step, own.targets, before, now);
                Decision::None
            }
            (
                State::Stick {
                    middle_mm,
                    radius_mm,
                },
                Gesture::Stick(own),
            ) => {
                let offset = [0, 1].map(|i| finger.at_mm[i] - middle_mm[i]);
                let [x, y] = stick::axes(own, offset, *radius_mm);
                for (axis, value) in [(own.x, x), (own.y, y)] {
                    if let Some(axis) = axis {
                        self.driver
                            .outputs
                            .axis(axis, value, step.t_ns, step.events);
                    }
                }
                Decision::None
            }
            (State::Trigger, Gesture::Trigger(own)) => {
                self.driver.outputs.axis(
                    own.axis,
                    force::pulled(own, finger.force),
                    step.t_ns,
                    step.events,
                );
                Decision::None
            }
            (State::Pointer(following), Gesture::Pointer(own)) => {
                if let Some(action) = following.moved(own, finger.at_mm) {
                    step.events.push(Event {
                        t_ns: step.t_ns,
                        action,
                    });
                }
                Decision::None
            }
            _ => Decision::None,
        };
        self.carry_out(step, at, decision);
    }

    /// Lets go of directions that are over, then presses the new ones.
    fn turn(&mut self, step: &mut Step<'_>, targets: [Option<Target>; 4], before: u8, now: u8) {
        for (bit, target) in targets.iter().enumerate() {
            if let Some(target) = target
                && before & !now & (1 << bit) != 0
            {
                self.driver.let_go(step, *target);
            }
        }
        for (bit, target) in targets.iter().enumerate() {
            if let Some(target) = target
                && now & !before & (1 << bit) != 0
            {
                self.driver.hold(step, *target);
            }
        }
    }

    /// Ends the gestures of one finger; those of several end in `gather`.
    fn end_where(&mut self, step: &mut Step<'_>, which: impl Fn(&Active) -> bool) {
        self.end_all(step, |active| {
            let of_several = matches!(
                active.state,
                State::Chord | State::Contacts | State::CrowdSwipe(_)
            );
            !of_several && which(active)
        });
    }

    pub(super) fn end_all(&mut self, step: &mut Step<'_>, which: impl Fn(&Active) -> bool) {
        let mut at = 0;
        while at < self.active.len() {
            if which(&self.active[at]) {
                self.end(step, at);
                self.active.remove(at);
            } else {
                at += 1;
            }
        }
    }

    /// A gesture's touch is over.
    fn end(&mut self, step: &mut Step<'_>, at: usize) {
        let Step { profile, t_ns, .. } = *step;
        let Active {
            touch,
            binding: index,
            state,
            ..
        } = self.active[at];
        let binding = &profile.bindings[index];
        match (state, &binding.gesture) {
            (State::Tap(tap), _) if tap.is_tap(t_ns) => self.carry_out(step, at, Decision::Pulse),
            (State::DoubleTap(DoubleTap::First(tap)), _) if tap.is_tap(t_ns) => {
                self.last_tap[index] = Some(t_ns)
            }
            (State::TapHold(undecided), _) => {
                let (decision, was_tap) = undecided.lift();
                self.carry_out(step, at, decision);
                if was_tap {
                    self.last_tap[index] = Some(t_ns);
                }
            }
            (State::Dpad { down, .. }, Gesture::Dpad(own)) => self.turn(step, own.targets, down, 0),
            (State::Stick { .. }, Gesture::Stick(own)) => {
                for axis in [own.x, own.y].into_iter().flatten() {
                    self.driver.outputs.axis(axis, 0.0, step.t_ns, step.events);
                }
            }
            (State::Trigger, Gesture::Trigger(own)) => {
                self.driver
                    .outputs
                    .axis(own.axis, 0.0, step.t_ns, step.events)
            }
            _ => {}
        }
        self.driver.end(step, index, touch);
    }

    /// Tells every undecided touch of another finger.
    fn tell_others(
        &mut self,
        step: &mut Step<'_>,
        id: TouchId,
        tell: fn(&mut Undecided, TouchId) -> Decision,
    ) {
        for at in 0..self.active.len() {
            let active = &mut self.active[at];
            if active.touch == id {
                continue;
            }
            if let State::TapHold(undecided) = &mut active.state {
                let decision = tell(undecided, id);
                self.carry_out(step, at, decision);
            }
        }
    }

    /// What a decision means for the outputs.
    pub(super) fn carry_out(&mut self, step: &mut Step<'_>, at: usize, decision: Decision) {
        let t_ns = step.t_ns;
        let Active {
            touch,
            binding: index,
            ..
        } = self.active[at];
        let driver = &mut self.driver;
        match decision {
            Decision::None => return,
            Decision::Begin(side) => driver.begin(step, index, touch, side),
            Decision::Swap => {
                driver.end(step, index, touch);
                driver.begin(step, index, touch, Side::Second);
            }
            Decision::Pulse => {
                driver.begin(step, index, touch, Side::First);
                driver.end(step, index, touch);
            }
        }
        self.last_press = Some(t_ns);
    }
}

pub(super) fn begin_if(begins: bool) -> Decision {
    if begins {
        Decision::Begin(Side::First)
    } else {
        Decision::None
    }
}
