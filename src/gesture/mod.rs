//! Turns touches and gamepad states into events. Each binding decides when its outputs are held; the outputs keep presses
//! and gaps long enough for games to see.
//!
//! ```text
//! Touch ─▶ panic ─▶ accept ─▶ layout ─▶ recognizers ─▶ driver ─▶ outputs ─▶ Event
//!                   which     which     which          how       how long
//! Control ─▶ parts ─▶ count   regions   gesture
//! ```
//! Time is passed in. A decision between two frames (the end of a minimum hold, a latch or a tapping term) is made at its
//! due time ([`Gestures::next_due`]), and the event carries that time, however late the call comes: events do not depend
//! on how frames are batched. No finger waits for another. After the profile is loaded, nothing allocates.

mod accept;
mod binding_index;
mod driver;
mod fingers;
mod layout;
mod moment;
mod outputs;
mod panic;
mod parts;
mod recognizers;
mod runtime;

use std::sync::Arc;

use crate::profile::Profile;
use crate::types::{Control, Event, NANOS_PER_MS, Nanos, Output, Touch};
use accept::Accept;
use layout::Layout;
use moment::Moment;
use panic::PanicDetector;
use parts::Parts;
use runtime::BindingRuntime;

/// A new profile waits at most this long for the outputs to be released.
const SWITCH_WAIT_NS: Nanos = 1000 * NANOS_PER_MS;

/// The gestures of one profile on one pad.
#[derive(Clone, Debug)]
pub struct Gestures {
    profile: Arc<Profile>,
    pad_mm: [f64; 2],
    panic: PanicDetector,
    layout: Layout,
    parts: Parts,
    accept: Accept,
    runtime: BindingRuntime,
    paused: bool,
    /// The profile that takes over, and the latest time for it.
    next: Option<(Arc<Profile>, Nanos)>,
    /// When the next decision is due.
    due: Option<Nanos>,
}

impl Gestures {
    /// The gestures of a profile on a pad of a size (width, height).
    #[must_use]
    pub fn new(profile: Arc<Profile>, pad_mm: [f64; 2]) -> Self {
        Self {
            panic: PanicDetector::new(&profile.settings),
            layout: Layout::new(&profile, pad_mm),
            accept: Accept::new(
                &profile.settings,
                profile.regions.len() + profile.parts.len(),
            ),
            parts: Parts::new(&profile),
            runtime: BindingRuntime::new(&profile),
            profile,
            pad_mm,
            paused: false,
            next: None,
            due: None,
        }
    }

    /// The current profile.
    #[must_use]
    pub fn profile(&self) -> &Arc<Profile> {
        &self.profile
    }

    /// The outputs that are down.
    pub fn held(&self) -> impl Iterator<Item = Output> + '_ {
        self.runtime.driver.outputs.held()
    }

    /// Whether only the gesture that ends the pause counts.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// When the next decision is due, if any is pending.
    #[must_use]
    pub fn next_due(&self) -> Option<Nanos> {
        self.due
    }

    /// Makes all decisions that are due by a time, in the order of their due times.
    pub fn tick(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        while let Some(due) = self.due.filter(|due| *due <= t_ns) {
            self.accept.tick(due);
            self.play_accepted(due, events);
            let Self {
                profile,
                layout,
                runtime,
                ..
            } = self;
            runtime.tick(&mut Moment {
                profile,
                layout,
                t_ns: due,
                events,
            });
            self.finish(due, events);
        }
    }

    /// Takes the changes of the touches in a frame.
    pub fn touches(&mut self, t_ns: Nanos, changed: &[Touch], events: &mut Vec<Event>) {
        self.tick(t_ns, events);
        // Large contacts come first: smaller parts of a resting arm are recognized by them.
        for large in [true, false] {
            for touch in changed {
                if self.accept.is_large(touch.contact.area_mm2) == large {
                    self.touch(t_ns, touch, events);
                }
            }
        }
    }

    fn touch(&mut self, t_ns: Nanos, touch: &Touch, events: &mut Vec<Event>) {
        let is_panic = self.panic.update(touch);
        if is_panic {
            self.pause(t_ns, !self.paused, events);
        }
        self.accept.touch(t_ns, touch, &self.layout);
        if is_panic {
            // The contact that completed the panic plays nothing.
            self.accept.accepted.clear();
        }
        self.play_accepted(t_ns, events);
        self.finish(t_ns, events);
        // What a touch makes due now comes before the next touch, so that one call or several give the same events.
        self.tick(t_ns, events);
    }

    /// Takes the state of gamepads and switches. Releases everything when the last one is unplugged.
    pub fn control(&mut self, control: &Control, events: &mut Vec<Event>) {
        let t_ns = control.t_ns;
        self.tick(t_ns, events);
        if !control.present {
            if self.parts.is_present() {
                self.release_all(t_ns, events);
            }
            return;
        }
        self.parts.update(control);
        for index in 0..self.parts.changes.len() {
            let change = self.parts.changes[index];
            self.accept.part(t_ns, &change);
            self.play_accepted(t_ns, events);
            self.finish(t_ns, events);
            self.tick(t_ns, events);
        }
    }

    /// Releases everything and forgets what was pending: the source was lost.
    pub fn release_all(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        self.end_gestures(t_ns, events);
        self.runtime.forget_fingers();
        self.accept.clear();
        self.parts.clear();
        self.panic.clear();
        self.finish(t_ns, events);
    }

    /// Pauses or resumes. Both release everything.
    pub fn pause(&mut self, t_ns: Nanos, paused: bool, events: &mut Vec<Event>) {
        self.paused = paused;
        self.runtime.paused = paused;
        self.end_gestures(t_ns, events);
        self.finish(t_ns, events);
    }

    /// Switches to another profile as soon as no output is down; after a second, outputs are released for it.
    /// Fingers that are down at the switch play nothing until they lift.
    pub fn replace(&mut self, profile: Arc<Profile>, t_ns: Nanos, events: &mut Vec<Event>) {
        self.tick(t_ns, events);
        self.next = Some((profile, t_ns + SWITCH_WAIT_NS));
        self.finish(t_ns, events);
    }

    /// Ends every gesture; fingers that are down play nothing more.
    fn end_gestures(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        let Self {
            profile,
            layout,
            runtime,
            ..
        } = self;
        runtime.release_all(&mut Moment {
            profile,
            layout,
            t_ns,
            events,
        });
    }

    fn play_accepted(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        let Self {
            profile,
            layout,
            runtime,
            accept,
            ..
        } = self;
        let mut moment = Moment {
            profile,
            layout,
            t_ns,
            events,
        };
        for accepted in accept.accepted.drain(..) {
            runtime.finger(&mut moment, &accepted);
        }
    }

    /// Completes a step: carries out a pause or a switch, and finds the time of the next decision.
    fn finish(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        if std::mem::take(&mut self.runtime.driver.pause_requested) {
            self.paused = !self.paused;
            self.runtime.paused = self.paused;
            self.end_gestures(t_ns, events);
        }
        if let Some((_, deadline_ns)) = self.next
            && (self.runtime.is_idle() || deadline_ns <= t_ns)
        {
            self.switch(t_ns, events);
        }
        let deadline = self.next.as_ref().map(|(_, deadline_ns)| *deadline_ns);
        self.due = [self.accept.next_due(), self.runtime.next_due(), deadline]
            .into_iter()
            .flatten()
            .min();
    }

    fn switch(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        let Some((profile, _)) = self.next.take() else {
            return;
        };
        self.end_gestures(t_ns, events);
        let panic = self.panic.clone().with_settings(&profile.settings);
        let parts = self.parts.clone().with_profile(&profile);
        let mut fresh = Self::new(profile, self.pad_mm);
        fresh.parts = parts;
        fresh.panic = panic;
        fresh.paused = self.paused;
        fresh.runtime.paused = self.paused;
        *self = fresh;
    }
}
