//! Touches, and the parts of gamepads, to events: each binding decides when it wants its output held, and the outputs see to it that no
//! press and no gap is shorter than a game can see.
//!
//! ```text
//! Touch ─▶ panic ─▶ accept ─▶ layout ─▶ one file a gesture ─▶ drive ─▶ outputs ─▶ Event
//!          safety    who       which     what it is           how      ref-counted
//! Control ─▶ parts ──▶ counts    places
//! ```
//! Time is passed in. A decision that falls between two frames (the end of a minimum hold, of a latch, of a tapping
//! term) is made at its due time, which [`Gestures::next_due`] tells; the event carries that time, however late the
//! call comes. So events do not depend on how frames are batched. No finger waits for another, and no step allocates
//! once the profile is loaded.

mod accept;
mod active;
mod begin;
mod crowd;
mod double_tap;
mod dpad;
mod drive;
mod fingers;
mod force;
mod hold;
mod latch;
mod layout;
mod outputs;
mod parts;
mod play;
mod pointer;
mod safety;
mod sequence;
mod step;
mod stick;
mod swipe;
mod tap;
mod tap_hold;

use std::sync::Arc;

use crate::profile::Profile;
use crate::types::{Control, Event, NANOS_PER_MS, Nanos, Output, Touch};
use accept::Accept;
use layout::Layout;
use parts::Parts;
use play::Players;
use safety::Panic;
use step::Step;

/// A new profile waits this long at most for the outputs to come up by themselves.
const SWITCH_WAIT_NS: Nanos = 1000 * NANOS_PER_MS;

/// The gestures of one profile on one pad.
#[derive(Clone, Debug)]
pub struct Gestures {
    profile: Arc<Profile>,
    pad_mm: [f64; 2],
    panic: Panic,
    layout: Layout,
    parts: Parts,
    accept: Accept,
    players: Players,
    paused: bool,
    /// The profile that takes over, and when at the latest.
    next: Option<(Arc<Profile>, Nanos)>,
    /// When the next decision falls, as of the last change.
    due: Option<Nanos>,
}

impl Gestures {
    /// Gestures of a profile on a pad of a size (width, height).
    #[must_use]
    pub fn new(profile: Arc<Profile>, pad_mm: [f64; 2]) -> Self {
        Self {
            panic: Panic::new(&profile.settings),
            layout: Layout::new(&profile, pad_mm),
            accept: Accept::new(
                &profile.settings,
                profile.regions.len() + profile.parts.len(),
            ),
            parts: Parts::new(&profile),
            players: Players::new(&profile),
            profile,
            pad_mm,
            paused: false,
            next: None,
            due: None,
        }
    }

    /// The profile in force.
    #[must_use]
    pub fn profile(&self) -> &Arc<Profile> {
        &self.profile
    }

    /// The outputs that are down.
    pub fn held(&self) -> impl Iterator<Item = Output> + '_ {
        self.players.driver.outputs.held()
    }

    /// Whether nothing counts but the gesture that ends the pause.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// When the next decision falls, if one is pending.
    #[must_use]
    pub fn next_due(&self) -> Option<Nanos> {
        self.due
    }

    /// Makes every decision that is due by a time, in the order in which they fall.
    pub fn tick(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        while let Some(due) = self.due.filter(|due| *due <= t_ns) {
            self.accept.tick(due);
            self.play_passed(due, events);
            let Self {
                profile,
                layout,
                players,
                ..
            } = self;
            players.tick(&mut Step {
                profile,
                layout,
                t_ns: due,
                events,
            });
            self.after(due, events);
        }
    }

    /// Takes what became of the touches in a frame.
    pub fn touches(&mut self, t_ns: Nanos, changed: &[Touch], events: &mut Vec<Event>) {
        self.tick(t_ns, events);
        // What rests comes first: the smaller parts of an arm that lies down are known by it.
        for large in [true, false] {
            for touch in changed {
                if self.accept.is_large(touch.contact.area_mm2) == large {
                    self.touch(t_ns, touch, events);
                }
            }
        }
    }

    fn touch(&mut self, t_ns: Nanos, touch: &Touch, events: &mut Vec<Event>) {
        let panic = self.panic.sees(touch);
        if panic {
            self.pause(t_ns, !self.paused, events);
        }
        self.accept.touch(t_ns, touch, &self.layout);
        if panic {
            // The contact that made it a panic plays nothing itself.
            self.accept.passed.clear();
        }
        self.play_passed(t_ns, events);
        self.after(t_ns, events);
        // What a touch makes due at this very time is done before the next touch: one call or several, the same events.
        self.tick(t_ns, events);
    }

    /// Takes what gamepads and switches say. When the last of them goes everything is released.
    pub fn control(&mut self, control: &Control, events: &mut Vec<Event>) {
        let t_ns = control.t_ns;
        self.tick(t_ns, events);
        if !control.present {
            if self.parts.is_present() {
                self.release_all(t_ns, events);
            }
            return;
        }
        self.parts.take(control);
        for index in 0..self.parts.changes.len() {
            let change = self.parts.changes[index];
            self.accept.part(t_ns, &change);
            self.play_passed(t_ns, events);
            self.after(t_ns, events);
            self.tick(t_ns, events);
        }
    }

    /// Releases everything now and forgets what was pending: the source is gone.
    pub fn release_all(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        self.let_go(t_ns, events);
        self.players.forget_fingers();
        self.accept.clear();
        self.parts.clear();
        self.panic.clear();
        self.after(t_ns, events);
    }

    /// Pauses or goes on. A pause releases everything.
    pub fn pause(&mut self, t_ns: Nanos, paused: bool, events: &mut Vec<Event>) {
        self.paused = paused;
        self.players.paused = paused;
        self.let_go(t_ns, events);
        self.after(t_ns, events);
    }

    /// Another profile from now on, or from when the outputs are up: a second later at most, and then they are released.
    /// Fingers that are down when it takes over belong to neither.
    pub fn replace(&mut self, profile: Arc<Profile>, t_ns: Nanos, events: &mut Vec<Event>) {
        self.tick(t_ns, events);
        self.next = Some((profile, t_ns + SWITCH_WAIT_NS));
        self.after(t_ns, events);
    }

    /// Ends every gesture; fingers that are down stay known, and give nothing more.
    fn let_go(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        let Self {
            profile,
            layout,
            players,
            ..
        } = self;
        players.release_all(&mut Step {
            profile,
            layout,
            t_ns,
            events,
        });
    }

    fn play_passed(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        let Self {
            profile,
            layout,
            players,
            accept,
            ..
        } = self;
        let mut step = Step {
            profile,
            layout,
            t_ns,
            events,
        };
        for passed in accept.passed.drain(..) {
            players.finger(&mut step, &passed);
        }
    }

    /// What a step may have left to do: a pause, a switch, and the time of the next decision.
    fn after(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        if std::mem::take(&mut self.players.driver.pause_wished) {
            self.paused = !self.paused;
            self.players.paused = self.paused;
            self.let_go(t_ns, events);
        }
        if let Some((_, deadline_ns)) = self.next
            && (self.players.is_idle() || deadline_ns <= t_ns)
        {
            self.switch(t_ns, events);
        }
        let deadline = self.next.as_ref().map(|(_, deadline_ns)| *deadline_ns);
        self.due = [self.accept.next_due(), self.players.next_due(), deadline]
            .into_iter()
            .flatten()
            .min();
    }

    fn switch(&mut self, t_ns: Nanos, events: &mut Vec<Event>) {
        let Some((profile, _)) = self.next.take() else {
            return;
        };
        self.let_go(t_ns, events);
        let panic = self.panic.clone().under(&profile.settings);
        let parts = self.parts.clone().under(&profile);
        let mut fresh = Self::new(profile, self.pad_mm);
        fresh.parts = parts;
        fresh.panic = panic;
        fresh.paused = self.paused;
        fresh.players.paused = self.paused;
        *self = fresh;
    }
}
